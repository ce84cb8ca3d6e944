"""The parts of accuracy.py: drives that are simulated and replayed, bars that they are held to, charts."""
