"""The report that is handed in: its figures and numbers, made from renders and from the tables of the benchmarks."""
