"""Both triangles of a symmetric matrix that is held by its upper one."""

from scipy import sparse


def full(matrix):
    upper = matrix.upper
    strictly = upper.data.copy()
    strictly[upper.indptr[:-1]] = 0.0
    above = sparse.bsr_array((strictly, upper.indices, upper.indptr), shape=upper.shape)
    return sparse.bsr_array(upper + above.T).tocsr()
