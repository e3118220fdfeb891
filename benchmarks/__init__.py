"""Speed and memory, measured: `python -m benchmarks`; what is measured and why is in docs/speed.md."""
