"""Amplitudes that B-lives are sampled on, against whole runs at other values.

    python tests/benchmarks/scatter.py [STUDY] [RPM] [MATERIAL] [SIZE] [COUNT]
    python tests/benchmarks/scatter.py responses [STUDY] [RPM] [MATERIAL] [SIZE] [COUNT]

Samples of the gas load are those of a fired engine, 3 % between cylinders, drawn at even quantiles, and
three standard deviations of single cycles, 5 %, at both ends. Each is run as a study with `gas_scale`; the
issue asks that amplitudes agree within 2 %.

`responses`: of preload (10 %), friction (20 %) and clearances (3 µm), as far as the study has them, all
sampled at once; each sample is solved as a whole cycle.
"""

import sys
from dataclasses import replace
from statistics import NormalDist

import numpy as np

import fea.analysis.cycle.figures as cycle_figures
from fea import analyse, load_study
from fea.analysis.cycle.operation import JudgedNodes
from fea.analysis.cycle.unit_solutions import spots
from fea.analysis.reliability import _bolts, _places
from fea.analysis.responses import _demand, causes, responses
from fea.analysis.scatter import scatter_of
from fea.judge.fatigue import reversed_amplitude
from fea.judge.history import rainflow
from fea.judge.reliability import responded
from fea.study.scatter_table import ScatterTable

CAUGHT = []


def caught(result, rod, operation):
    CAUGHT.append((result, rod, operation))


def run(study, rpm, size):
    cycle_figures.reliability_figures = caught
    analyse(study, rpm=rpm, size=size, tolerance=0, cycle=True, elastic=True)
    return CAUGHT.pop()


def places_of(result, rod, operation):
    found = result.envelope
    nodes = JudgedNodes(found.fatigue_factor, found.fatigue_part, result.counts, result.regions)
    return list(_places(operation, nodes, rod, scatter_of(None, rod.loading, rod.options.fatigue)))


def main(name="leon-2001", rpm=4300.0, material="forged-steel-2005", size=12.0, count=20):
    study = load_study(name).with_(material=material)
    result, rod, operation = run(study, float(rpm), float(size))
    places = places_of(result, rod, operation)
    shares = (np.arange(int(count) - 2) + 0.5) / (int(count) - 2)
    factors = [1 + 0.03 * NormalDist().inv_cdf(share) for share in shares] + [0.85, 1.15]
    worst = 0.0
    for factor in factors:
        other, whole, _ = run(study.with_(engine={"gas_scale": factor}), float(rpm), float(size))
        for place in places:
            part = int(result.envelope.fatigue_part[place.node])
            (spot,) = spots([(place.node, part)], whole.cycle.units, other.weights, whole.mesh.mirrored)
            cycles = rainflow(spot.signed)
            exact = float(reversed_amplitude(whole.options.fatigue, *cycles, whole.materials[part]).max())
            found = float(np.interp(factor, place.gas, place.amplitude[:, 0]))
            apart = found / exact - 1
            worst = max(worst, abs(apart))
            print(f"{factor:.3f} {place.name:28s} {found:8.2f} {exact:8.2f} MPa {100 * apart:+.2f} %")
    print(f"largest difference {100 * worst:.2f} %")


def main_responses(name="leon-2001-bolted", rpm=4500.0, material="forged-steel-2005", size=24.0, count=6):
    result, rod, operation = run(load_study(name).with_(material=material), float(rpm), float(size))
    of_parts = {"preload_percent": 10.0, "friction_percent": 20.0} if rod.assembling else {}
    rod = replace(rod, study=replace(rod.study, scatter=ScatterTable(clearance_um=3.0, **of_parts)))
    places = [*places_of(result, rod, operation), *_bolts(operation, rod)]
    where = [(place.node, int(result.envelope.fatigue_part[place.node])) for place in places if place.node]
    every, cycle = list(causes(rod)), operation.entries[0].cycle
    solved, now = responses(rod, operation, where, every), _demand(rod, cycle, where)
    for z in np.random.default_rng(0).normal(size=(int(count), len(every))):
        changed = {}
        for cause, away in zip(every, z, strict=True):
            _, low, high, _ = cause.values  # a deviation below and above the mean
            made = changed.get(cause.field, getattr(rod.structure, cause.field))
            for key, value in vars(low).items():
                if value != (other := getattr(high, key)):
                    made = replace(made, **{key: (value + other) / 2 + away * (other - value) / 2})
            changed[cause.field] = made
        exact = np.exp(_demand(rod.with_pins(**changed), cycle, where) - now)
        found = np.exp([sum(map(responded, z, one)) for one in solved])
        print(", ".join(f"{cause.name} {away:+.2f}" for cause, away in zip(every, z, strict=True)))
        for place, one, other in zip(places, found, exact, strict=True):
            print(f"    {place.name:28s} {one:6.3f} {other:6.3f} {100 * (one / other - 1):+.2f} %")


if __name__ == "__main__":
    if sys.argv[1:2] == ["responses"]:
        main_responses(*sys.argv[2:])
    else:
        main(*sys.argv[1:])
