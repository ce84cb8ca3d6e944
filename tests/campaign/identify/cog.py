"""odom identify cog, with a tape measure and a car that is never quite level."""

from .mass import weigh
from .rows import each, findings, judge, sample

NAMES = {"centre of gravity to front axle": "front_axle",
         "centre of gravity to rear axle": "rear_axle",
         "centre of gravity left of the middle": "lateral"}


def run(seeds, work, odom):
    def one(seed):
        truth, _ = weigh(odom, work / str(seed), seed)
        found, _ = findings(odom, "cog", "--measured", work / str(seed) / "measured.json")
        return [sample(truth[key], found[name]) for name, key in NAMES.items()]

    columns = zip(*each(seeds, one))
    return [judge(f"cog: {key}", list(column), unit="mm", scale=1e3)
            for key, column in zip(NAMES.values(), columns)]
