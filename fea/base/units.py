"""The one converter between engineering units and the coherent system mm, N, MPa, t, s, rad.

Multiply by a constant to convert input, divide by it to convert output: ``mass = 0.785 * KG``.
"""

import math

M = 1e3
GPA = 1e3
BAR = 0.1
KG = 1e-3
KG_M2 = 1e3  # t·mm²
KG_M3 = 1e-12  # t/mm³
N_M = 1e3  # N·mm
KN = 1e3
UM = 1e-3
M_S = 1e3
M_S2 = 1e3
DEG = math.pi / 180
RPM = 2 * math.pi / 60
