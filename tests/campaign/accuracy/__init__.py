"""The parts of accuracy.py: simulated and replayed drives, bars for them, charts."""
