"""What every test stands on."""

import os

# Matrices here are small: BLAS's own threads cost more than they bring, and many times that
# where several processes test at once. Before NumPy is imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
