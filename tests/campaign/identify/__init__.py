"""The methods of odom identify on simulated cars: a module each, with run(seeds, work, odom) -> rows.

`seeds` are the numbers to draw cars by, `work` is a folder of the module's own, `odom` the program.
"""
