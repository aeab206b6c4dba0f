#!/usr/bin/env bash
# FLife 2.3: an amplitude spectrum is taken as root mean squares, and by LiWI as a density.
#
# Valid input: a sine of amplitude 1 at 20 Hz as {"amplitude_spectrum": ..., "f": ...}, lines 1, 0.5 and
# 0.25 Hz apart: as uniaxial stress, and as the first stress of the plane stresses (N, f, 3) of two points.
#
# Guess: variance 0.5 each time, as that of the same sine given as a time history, and one narrowband
# life, 1e6/20/Gamma(3.5) = 15045 s with C = 1e6 and k = 5.
#
# Seen: variance 1 and a life 2^2.5 = 5.7 times too short of the uniaxial spectrum (the square over the
# lines' distance, without the half), in a history made of it too. Of two points LiWI squares lines and
# does not divide: a density, so the variance is the lines' distance, 1 to 0.25, and the life goes by
# its power. No warning. Of one point `liwi` raises an AttributeError.
#
# Divide amplitudes by sqrt(2) before giving them (for LiWI by sqrt(2 df)), or give a power density.
#
# Run by hand: bash findings/flife_amplitude_spectrum.sh. Needs Python 3.11 or later and a package index.
# It fails if the output is another one.
set -euo pipefail
here=$(mktemp -d)
trap 'rm -rf "$here"' EXIT
python3 -m venv "$here/venv"
"$here/venv/bin/pip" install --quiet FLife==2.3 numpy==2.4.6 scipy==1.17.1
cd "$here"
"$here/venv/bin/python" -W ignore > seen <<'PYTHON'
import contextlib
import io

import FLife
import numpy as np

C, K = 1e6, 5
quiet = contextlib.redirect_stdout(io.StringIO())


def life(variance_of):
    return FLife.Narrowband(variance_of).get_life(C, K)


sine = np.sin(2 * np.pi * 20 * np.arange(0, 200, 0.005))
history = FLife.SpectralData({"time_history": sine, "dt": 0.005})
print(f"history: variance {history.moments[0]:.3f}, life {life(history):.0f} s")
for step in (1.0, 0.5, 0.25):
    f = np.arange(0, 100 + step / 2, step)
    amplitude = np.where(f == 20, 1.0, 0.0)
    plane = np.zeros((2, len(f), 3), complex)
    plane[:, :, 0] = amplitude
    with quiet:
        uniaxial = FLife.SpectralData({"amplitude_spectrum": amplitude, "f": f}, T=100, fs=400)
        several = FLife.EquivalentStress({"amplitude_spectrum": plane, "f": f})
        several.liwi()
    density = several.eq_psd_multipoint[0][0]
    with quiet:
        as_density = FLife.SpectralData({"PSD": density, "f": f})
    print(f"lines {step} Hz apart: variance {uniaxial.moments[0]:.3f}, made history "
          f"{np.var(uniaxial.data):.3f}, life {life(uniaxial):.0f} s; "
          f"LiWI {as_density.moments[0]:.3f}, {life(as_density):.0f} s")
try:
    one = FLife.EquivalentStress({"amplitude_spectrum": plane[0], "f": f})
    one.liwi()
except AttributeError:
    print("LiWI of one point: AttributeError")
PYTHON
cat > expected <<'TEXT'
history: variance 0.500, life 15045 s
lines 1.0 Hz apart: variance 1.000, made history 1.000, life 2660 s; LiWI 1.000, 2660 s
lines 0.5 Hz apart: variance 1.000, made history 1.000, life 2660 s; LiWI 0.500, 15045 s
lines 0.25 Hz apart: variance 1.000, made history 1.000, life 2660 s; LiWI 0.250, 85108 s
LiWI of one point: AttributeError
TEXT
diff expected seen
