"""The parts of accuracy.py: simulated and replayed drives, and bars for them."""
