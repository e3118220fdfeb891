"""What everything stands on: backend and its types, records, maths without rendering knowledge, errors."""
