#!/usr/bin/env bash
# Runs the zoo of extreme surfaces and writes docs/zoo.md: bench/zoo.sh
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/setup.sh"
build zoo zoo_of_lobes constant_reflectance
{
  cat <<'TEXT'
# The zoo of extreme surfaces

Small surfaces on which a closed form per triangle can judge every node of a table (`libmicro/testing/zoo.cpp`;
the tests hold them to the same promises). D_K is the spectral estimator's 65² table at tol 1e-3: the error it
*said* it reached, and the relative L2 error *found* against `exact` on every node, over the table and without
its coherent core. What cannot be computed is refused with the reason. `bench/zoo.sh` wrote this file.

TEXT
  build/release/bench/zoo
  cat <<'TEXT'

# The zoo of lobes

Extreme parameters of the ellipsoid NDF and of Beckmann (`libmicro/testing/lobe_zoo.cpp`; widths 1e-5 … 1e3, ratios to 1e5,
tilts to the horizon). Relative distance of D and G1 from the printed formulas in 50 digits, over 200 sampled normals:
the last digit of a tilt or of a direction moves a needle by more of its width. Samples: how many of 10,000 lie in the
half of the lobe nearest to its centre, less half, in standard errors. A table of the lobe is fitted: status, and the
distance of the frame found, in widths in slope space. A table that ends before a needle does, or whose nodes are
wider apart than a lobe, cannot tell it, and the status says so.

TEXT
  build/release/bench/zoo_of_lobes
  cat <<'TEXT'

# What a constant reflectance costs

D_K takes the Fresnel amplitude out of the integral over the surface ([Dong15 Eq. 6] for Eq. 3, light of polarisation s,
0.5486 µm). `exact_field` also takes an amplitude that varies from facet to facet. Relative L2 difference
of |F|² between the two, 40 directions around the mirror's, Gaussian surfaces of rms 0.3 µm:

TEXT
  build/release/bench/constant_reflectance
} >docs/zoo.md.new
mv docs/zoo.md.new docs/zoo.md
