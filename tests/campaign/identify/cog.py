"""odom identify cog, with a car that is never quite level and a tape."""

from .mass import scale, weigh
from .rows import each, findings, judge, options, sample

NAMES = {"centre of gravity to front axle": "front_axle",
         "centre of gravity to rear axle": "rear_axle",
         "centre of gravity left of the middle": "lateral"}


def run(seeds, work, odom):
    def one(seed):
        measured, truth = weigh(odom, work / str(seed), seed)
        tape = {}
        for name in "wheelbase", "track_width":
            tape[name] = measured[name]["value"]
            tape[name + "_sigma"] = measured[name]["sigma"]
        found, _ = findings(odom, "cog", *scale(measured), *options(**measured["loads"], **tape),
                            *options(level=measured["level"]))
        return [sample(truth[key], found[name]) for name, key in NAMES.items()]

    columns = zip(*each(seeds, one))
    return [judge(f"cog: {key}", list(column), unit="mm", scale=1e3)
            for key, column in zip(NAMES.values(), columns)]
