"""The methods of odom identify on simulated cars: one module each, with run(seeds, work, odom) -> rows.

`seeds` are the numbers to draw cars by, `work` is a folder of the module's own, `odom` the program.
"""
