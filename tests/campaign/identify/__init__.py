"""The methods of odom identify on simulated cars: one module each, with run(seeds, work, odom) -> rows.

`seeds`: the random seeds of the cars; `work`: a folder for this module alone; `odom`: the program.
"""
