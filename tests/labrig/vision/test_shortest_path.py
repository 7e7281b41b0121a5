"""The cheapest path over a map's pixels."""

import numpy as np
import pytest
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from labrig.vision.search.shortest_path import shortest_path


def test_the_shortest_path_is_that_of_scipy():
    rng = np.random.default_rng(4)
    cost = rng.uniform(0.05, 1.0, (23, 31)).astype(np.float32)
    rows, columns = cost.shape
    edges = []
    for i in range(rows):
        for j in range(columns):
            for k in range(max(0, i - 1), min(rows, i + 2)):
                for m in range(max(0, j - 1), min(columns, j + 2)):
                    if (i, j) != (k, m):
                        length = np.hypot(k - i, m - j)
                        price = 0.5 * length * (float(cost[i, j]) + float(cost[k, m]))
                        edges.append((i * columns + j, k * columns + m, price))
    start, end, price = (np.array(each) for each in zip(*edges, strict=True))
    graph = coo_matrix((price, (start, end)), shape=(cost.size, cost.size)).tocsr()
    least = dijkstra(graph, indices=40)[650]
    path = shortest_path(cost, 40, 650)
    assert (path[0], path[-1]) == (40, 650)
    steps = graph[path[:-1], path[1:]]
    assert (steps > 0).all()
    assert float(steps.sum()) == pytest.approx(float(least), rel=1e-9)
