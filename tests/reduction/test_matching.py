"""Matching of equations to unknowns, by CasADi and by SciPy, beside counts of what fits."""

import networkx as nx
import numpy as np
import pytest
import scipy

from lumped.reduction import matching
from lumped.support.sparse_graph import find_sets, find_strong_sets


@pytest.fixture(params=["CasADi", "SciPy"])
def by_each(request, monkeypatch):
    monkeypatch.setattr(matching, "_MANY", 10**9 if request.param == "CasADi" else 0)


def draw_graphs(square):
    rng = np.random.default_rng(3)
    for _ in range(150):
        n, m = rng.integers(1, 9, 2)
        m = n if square else m
        count = rng.integers(0, 3 * n)
        yield rng.integers(0, n, count), rng.integers(0, m, count), (int(n), int(m))


def rank(rows, columns, shape, without=()):
    """Greatest number of rows with columns of their own, without some rows."""
    kept = ~np.isin(rows, without)
    pattern = scipy.sparse.coo_array((np.ones(kept.sum()), (rows[kept], columns[kept])), shape)
    return scipy.sparse.csgraph.structural_rank(pattern.tocsr())


@pytest.mark.usefixtures("by_each")
def test_rows_compete_if_all_columns_can_be_taken_without_any_of_them():
    for graph in draw_graphs(square=False):
        full = rank(*graph)
        expected = [r for r in range(graph[2][0]) if rank(*graph, without=[r]) == full]
        assert matching.find_overdetermined(*graph).tolist() == expected


@pytest.mark.usefixtures("by_each")
def test_each_row_has_a_column_of_its_own_where_that_is_possible():
    complete = 0
    for graph in draw_graphs(square=True):
        rows, columns, (n, _) = graph
        found = matching.match_rows(*graph)
        held = found[found >= 0].tolist()
        assert len(set(held)) == len(held) == rank(*graph)
        assert set(enumerate(found.tolist())) - set(zip(rows, columns, strict=True)) == {
            (r, -1) for r in np.flatnonzero(found < 0)
        }
        assert matching.can_match_all(*graph) == (rank(*graph) == n)
        complete += matching.can_match_all(*graph)
    assert 10 < complete < 140


def test_sets_are_numbered_by_their_first_member():
    for rows, columns, (n, _) in draw_graphs(square=True):
        directed = nx.DiGraph(zip(rows.tolist(), columns.tolist(), strict=True))
        directed.add_nodes_from(range(n))
        expected = sorted(map(sorted, nx.strongly_connected_components(directed)))
        found = find_strong_sets(rows, columns, n)
        assert [np.flatnonzero(found == k).tolist() for k in range(len(expected))] == expected
        expected = sorted(map(sorted, nx.connected_components(directed.to_undirected())))
        found = find_sets(np.column_stack([rows, columns]), n)
        assert [np.flatnonzero(found == k).tolist() for k in range(len(expected))] == expected
