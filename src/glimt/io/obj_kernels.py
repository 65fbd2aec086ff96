"""What an OBJ file needs of compiled geometry: equal rows, smooth edges, ear clipping."""

import numpy as np

from glimt.kernel import inline, kernel


@kernel
def first_rows(rows, seed, table, ids, firsts):
    """Give different rows a number each, in order of appearance: row i equals row ``firsts[ids[i]]``. Return how many.

    rows : (n, 3) int32
    seed : uint64
        Stirs the hash table: without knowing it nobody can write a file whose rows all collide. It changes no result.
    table : (s,) int32, each -1
        s is a power of two above n.
    ids, firsts : (n,) int32
        Filled; only the first rows of `firsts`.
    """
    mask = np.uint64(len(table) - 1)
    count = 0
    for i in range(len(rows)):
        a, b, c = rows[i, 0], rows[i, 1], rows[i, 2]
        slot = seed
        for word in (a, b, c):  # splitmix64 (Steele, Lea, Flood, "Fast splittable pseudorandom generators", 2014)
            slot = (slot ^ np.uint64(np.uint32(word))) * np.uint64(0xBF58476D1CE4E5B9)
            slot = (slot ^ (slot >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
            slot ^= slot >> np.uint64(31)
        slot &= mask
        found = table[slot]
        while found >= 0:
            row = firsts[found]
            if rows[row, 0] == a and rows[row, 1] == b and rows[row, 2] == c:
                break
            slot = (slot + np.uint64(1)) & mask
            found = table[slot]
        if found < 0:
            found = count
            table[slot], firsts[count] = count, i
            count += 1
        ids[i] = found
    return count


@inline
def _root(parents, i):
    while parents[i] != i:
        parents[i] = parents[parents[i]]
        i = parents[i]
    return i


@kernel
def smooth_corners(vertices, edges, normals, cosine, parents, latest):
    """Label corners: those at one vertex share a label where smooth edges join their triangles.

    vertices : (3m,) int32
        Vertex of each corner; a triangle has three in a row.
    edges : (3m,) int32
        Below 3m: the edge from each corner to the next of its triangle, the same from either side.
    normals : (m, 3) float64, unit
    cosine : float64
        An edge is smooth where the normals beside it make an angle of at most arccos(cosine).
    parents : (3m,) int32
        Counts up from 0; becomes the labels.
    latest : (3m,) int32, each -1
    """
    for i in range(len(vertices)):
        j = latest[edges[i]]
        latest[edges[i]] = i
        if j < 0:
            continue
        n, m = normals[i // 3], normals[j // 3]
        if n[0] * m[0] + n[1] * m[1] + n[2] * m[2] < cosine:
            continue
        i_next, j_next = i + 1 - 3 * (i % 3 == 2), j + 1 - 3 * (j % 3 == 2)
        if vertices[i] == vertices[j]:
            j, j_next = j_next, j
        parents[_root(parents, i)] = _root(parents, j_next)
        parents[_root(parents, i_next)] = _root(parents, j)
    for i in range(len(vertices)):
        parents[i] = _root(parents, i)


@inline
def _turn(points, a, b, c):
    """Return twice the signed area of a triangle: positive where a, b, c turn left."""
    return ((points[b, 0] - points[a, 0]) * (points[c, 1] - points[a, 1])
            - (points[b, 1] - points[a, 1]) * (points[c, 0] - points[a, 0]))


@inline
def _same(points, a, b):
    return points[a, 0] == points[b, 0] and points[a, 1] == points[b, 1]


@inline
def _first_inside(points, reflex, count, a, b, c):
    """Return which reflex corner is the first in the triangle or on its edges, `count` for none.

    Those at its corners do not count.
    """
    for k in range(count):
        p = reflex[k]
        if (_turn(points, a, b, p) >= 0 and _turn(points, b, c, p) >= 0 and _turn(points, c, a, p) >= 0
                and not (_same(points, p, a) or _same(points, p, b) or _same(points, p, c))):
            return k
    return count


@kernel
def clip_ears(points, starts, triangles, budget, scratch):
    """Cut polygons into triangles by clipping ears (Meisters, "Polygons have ears", 1975); return the steps it took.

    points : (n, 2) float64
        Corners of all polygons, counter-clockwise.
    starts : (p + 1,) int64
        Polygon i has the points from starts[i] up to starts[i + 1], at least 3.
    triangles : (n - 2p, 3) int64
        Filled with rows of `points`, always corners - 2 for each polygon. Where no ear is left (a polygon that crosses
        itself) a flat corner is cut off, failing that any.
    budget : int64
        After so many steps, which grow with the square of the corners, corners are cut off unseen.
    scratch : (4, n) int64
    """
    before, after, reflex, place = scratch[0], scratch[1], scratch[2], scratch[3]
    row, steps = 0, 0
    for polygon in range(len(starts) - 1):
        first, end = starts[polygon], starts[polygon + 1]
        count = np.int64(0)
        for i in range(first, end):
            before[i] = i - 1 if i > first else end - 1
            after[i] = i + 1 if i + 1 < end else first
            place[i] = -1
            if _turn(points, before[i], i, after[i]) <= 0:
                reflex[count], place[i] = i, count
                count += 1
        b, remaining, misses = first, end - first, 0
        while remaining > 3:
            a, c = before[b], after[b]
            turn = _turn(points, a, b, c)
            steps += 1
            is_ear = (steps > budget or misses >= 2 * remaining or (misses >= remaining and turn == 0))
            if not is_ear and turn > 0:
                blocked = _first_inside(points, reflex, count, a, b, c)
                steps += blocked
                is_ear = blocked == count
            if not is_ear:
                misses += 1
                b = c
                continue
            triangles[row, 0], triangles[row, 1], triangles[row, 2] = a, b, c
            row += 1
            after[a], before[c] = c, a
            remaining -= 1
            misses = 0
            for i in (a, b, c):  # who is no longer reflex leaves the list; its last entry takes the place
                if place[i] >= 0 and (i == b or _turn(points, before[i], i, after[i]) > 0):
                    count -= 1
                    reflex[place[i]], place[reflex[count]] = reflex[count], place[i]
                    place[i] = -1
            b = after[c]  # not c: ears side by side would make a fan of slivers
        triangles[row, 0], triangles[row, 1], triangles[row, 2] = before[b], b, after[b]
        row += 1
    return steps
