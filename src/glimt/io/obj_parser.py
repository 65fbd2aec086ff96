"""OBJ text to arrays, compiled: one pass over the bytes counts, a second one parses.

Tests are spelled out (`a == b or a == c`) and arrays come from the caller because of the time it takes to compile.

The text ends lines with LF, CR LF or CR. A backslash before a line end continues the statement: the caller has turned
that line end into `CONTINUED`, a blank that counts as a line. A comment runs to the end of its line in any case.
"""

import numpy as np

from glimt.kernel import inline, kernel, routine

CONTINUED = 11  # the vertical tab
_LF, _CR = 10, 13
_BLANK = 32  # and everything below
_HASH, _SLASH, _PLUS, _MINUS, _DOT, _ZERO, _NINE = 35, 47, 43, 45, 46, 48, 57

# How a parse ends.
OK, BAD_NUMBER, BAD_CORNER, TOO_FEW, TOO_LARGE, INDEX_ZERO, OUT_OF_RANGE, NO_NORMAL, TOO_MANY_CORNERS = range(9)

# Rows of `notes`: (count, first line).
COLORS, FEW_CORNERS, MISSING_NORMAL, SMOOTHING, BAD_SMOOTHING = range(5)
NOTES = 5

ABSENT = -1
MAX_CORNERS = 65536
_POWERS = 10.0 ** np.arange(23)  # each is exact


def word_of(name: str) -> int:
    """Return the first 8 bytes of a statement's name as one number."""
    return int.from_bytes(name.encode()[:8], "little")


_V, _VT, _VN, _F, _FO, _S, _O, _G = (word_of(name) for name in ("v", "vt", "vn", "f", "fo", "s", "o", "g"))
USEMTL, MTLLIB = word_of("usemtl"), word_of("mtllib")


@inline
def _skip_blanks(data, i, stop):
    while i < stop and data[i] <= _BLANK:
        i += 1
    return i


@routine
def _count_tokens(data, i, stop):
    tokens, in_token = 0, False
    while i < stop:
        tokens += data[i] > _BLANK and not in_token
        in_token = data[i] > _BLANK
        i += 1
    return tokens


@routine
def _statement(data, i):
    """Return (word, begin, stop, end, following, lines) of the statement at `i`.

    Its arguments are data[begin:stop] without comment and data[begin:end] with it; `following` starts the next one,
    `lines` further down. An empty line has word 0.
    """
    size = len(data)
    end, stop, lines = i, -1, 1
    while end < size:
        byte = data[end]
        if byte <= _HASH:
            if byte == _LF or byte == _CR:  # noqa: SIM109
                break
            if byte == _HASH and stop < 0:
                stop = end
            if byte == CONTINUED:
                if stop >= 0:
                    break
                lines += 1
        end += 1
    if stop < 0:
        stop = end
    following = end + 1
    if end + 1 < size and data[end] == _CR and data[end + 1] == _LF:
        following += 1
    begin, word, shift = _skip_blanks(data, i, stop), 0, 0
    while begin < stop and data[begin] > _BLANK:
        if shift < 64:
            word |= np.int64(data[begin]) << shift
        shift += 8
        begin += 1
    return word, begin, stop, end, following, lines


@routine
def _number(data, i, stop):
    """Return (value, end of the token), or (0, -1) where it is no number; "nan" and "inf" are NaN."""
    negative = data[i] == _MINUS
    if negative or data[i] == _PLUS:
        i += 1
    first, mantissa, exponent, digits, point = i, 0, 0, 0, False
    while i < stop:
        byte = data[i]
        if _ZERO <= byte <= _NINE:
            digits += 1
            if mantissa < 9 * 10**17:
                mantissa = mantissa * 10 + (byte - _ZERO)
                exponent -= point
            else:
                exponent += not point
        elif byte == _DOT and not point:
            point = True
        else:
            break
        i += 1
    if digits == 0:
        letter = data[first] | 32 if first < stop else 0
        if first < i or (letter != 110 and letter != 105):  # n of nan, i of inf
            return 0.0, -1
        while i < stop and data[i] > _BLANK:
            i += 1
        return np.nan, i
    if i < stop and data[i] | 32 == 101:  # e
        given, i = _integer(data, i + 1, stop)
        exponent += given
    if i < 0 or (i < stop and data[i] > _BLANK):
        return 0.0, -1
    value = float(mantissa)
    if mantissa == 0 or exponent < -400:
        value, exponent = 0.0, 0
    elif exponent > 400:
        exponent = 400
    while exponent > 22:
        value *= 1e22
        exponent -= 22
    while exponent < -22:
        value /= 1e22
        exponent += 22
    value = value * _POWERS[exponent] if exponent >= 0 else value / _POWERS[-exponent]
    return (-value if negative else value), i


@routine
def _integer(data, i, stop):
    """Return (value, end of its digits), or (0, -1) without a digit; huge ones stay at about 10**12."""
    negative = i < stop and data[i] == _MINUS
    if negative or (i < stop and data[i] == _PLUS):
        i += 1
    first, value = i, 0
    while i < stop and _ZERO <= data[i] <= _NINE:
        if value < 10**12:
            value = value * 10 + (data[i] - _ZERO)
        i += 1
    return (-value if negative else value), (i if i > first else -1)


@kernel
def count(data, counts):
    """Count the v, vt, vn and f statements of `data`, corners of faces, and usemtl and mtllib statements.

    data : (size,) uint8
    counts : (6,) int64, zeros
    """
    i = np.int64(0)  # not a literal, for which the functions called would be compiled once more
    while i < len(data):
        word, begin, stop, _, i, _ = _statement(data, i)
        if word == _V:
            counts[0] += 1
        elif word == _VT:
            counts[1] += 1
        elif word == _VN:
            counts[2] += 1
        elif word == _F or word == _FO:  # noqa: SIM109
            counts[3] += 1
            counts[4] += _count_tokens(data, begin, stop)
        elif word == USEMTL or word == MTLLIB:  # noqa: SIM109
            counts[5] += 1


@routine
def _vector(data, i, stop, out, largest):
    """Fill `out` with two texcoords, one is enough, or three numbers; return (error, where it is or the end).

    Beyond `largest` or not finite is an error; `largest` 0 lets everything pass.
    """
    for axis in range(len(out)):
        i = _skip_blanks(data, i, stop)
        if i >= stop:
            if axis == 0 or len(out) == 3:
                return TOO_FEW, i
            out[axis] = 0
            continue
        value, end = _number(data, i, stop)
        if end < 0:
            return BAD_NUMBER, i
        if largest > 0 and not abs(value) <= largest:
            return TOO_LARGE, i
        out[axis] = value
        i = end
    return OK, i


@inline
def _corner(data, i, stop, counts, totals, out):
    """Fill `out` with the indices from 0 of v, v/vt, v//vn or v/vt/vn; return (error, its place or the corner's end).

    counts, totals : (3,) int64
        How many v, vt and vn have been read so far (negative indices count back from there), and in the whole file.
    `NO_NORMAL`, where the normal lies past the end of the file's, is no reason to stop.
    """
    out[:] = ABSENT
    error = OK
    for part in range(3):
        if part > 0:
            if i >= stop or data[i] != _SLASH:
                break
            i += 1
            if i >= stop or data[i] == _SLASH or data[i] <= _BLANK:
                continue
        value, end = _integer(data, i, stop)
        if end < 0:
            return BAD_CORNER, i
        if value == 0:
            return INDEX_ZERO, i
        index = value - 1 if value > 0 else counts[part] + value
        if 0 <= index < totals[part]:
            out[part] = index
        elif part == 2 and index >= 0:
            error = NO_NORMAL
        else:
            return OUT_OF_RANGE, i
        i = end
    if i < stop and data[i] > _BLANK:
        return BAD_CORNER, i
    return error, i


@routine
def _face(data, i, stop, counts, totals, corners, first):
    """Write a face's corners from row `first` on; return (error, place, corners written, normals missing)."""
    row, missing = first, 0
    i = _skip_blanks(data, i, stop)
    while i < stop:
        error, place = _corner(data, i, stop, counts, totals, corners[row])
        if error == NO_NORMAL:
            missing += 1
        elif error != OK:
            return error, place, 0, 0
        row += 1
        if row - first > MAX_CORNERS:
            return TOO_MANY_CORNERS, i, 0, 0
        i = _skip_blanks(data, place, stop)
    return OK, i, row - first, missing


@inline
def _note_word(others, word, line):
    """Count a statement that is not read; the last row, word 0, takes what is beyond the table."""
    last = len(others) - 1
    for row in range(last + 1):
        if others[row, 1] == 0:
            others[row, 0], others[row, 2] = (word if row < last else 0), line
        if others[row, 0] == word or row == last:
            others[row, 1] += 1
            break


@inline
def _smoothing_group(data, i, stop):
    """Return a smoothing group (0: off), or -1 for what is none."""
    i = _skip_blanks(data, i, stop)
    value, end = _integer(data, i, stop)
    if end < 0:
        is_word = i + 1 < stop and data[i] | 32 == 111  # "on" and "off"
        return (1 if data[i + 1] | 32 == 110 else 0) if is_word else -1
    return value if 0 <= value < 2**31 else -1


@kernel
def parse(data, totals, counts, positions, texcoords, normals, corners, faces, names, others, notes, largest):
    """Fill the arrays with what `data` says; return (error, line, word, place in `data`, faces kept) as int64.

    data : (size,) uint8
    totals, counts : (3,) int64
        How many v, vt and vn the file has, and as many zeros.
    positions, texcoords, normals : (n, 3), (n, 2), (n, 3) float32
        Sized by `count`. A normal may hold NaN.
    corners : (n, 3) int32
        Indices of v, vt, vn from 0, `ABSENT` for none; faces follow one another.
    faces : (n + 1, 4) int64
        First corner, line, smoothing group (0: off), how many names came before; the last row only ends the corners.
        A face of fewer than three corners is left out; `notes[FEW_CORNERS]` says how many.
    names : (n, 4) int64
        Word (`USEMTL` or `MTLLIB`), line, begin, end of its text in `data`.
    others : (16, 3) int64, zeros
        Word, count, first line of statements that are not read.
    notes : (NOTES, 2) int64, zeros
    largest : float64
        Coordinates beyond it are an error.
    """
    corner = face = name = group = i = np.int64(0)
    line = np.int64(1)
    while i < len(data):
        word, begin, stop, end, i, lines = _statement(data, i)
        error, place, note, times = OK, begin, -1, 1
        if word == _V:
            error, place = _vector(data, begin, stop, positions[counts[0]], largest)
            counts[0] += 1
            if error == OK and _count_tokens(data, place, stop) >= 3:
                note = COLORS
        elif word == _VT:
            error, place = _vector(data, begin, stop, texcoords[counts[1]], largest)
            counts[1] += 1
        elif word == _VN:
            error, place = _vector(data, begin, stop, normals[counts[2]], 0.0)
            counts[2] += 1
        elif word == _F or word == _FO:  # noqa: SIM109
            error, place, written, missing = _face(data, begin, stop, counts, totals, corners, corner)
            if missing > 0:
                note, times = MISSING_NORMAL, missing
            if written >= 3:
                faces[face, 0], faces[face, 1], faces[face, 2], faces[face, 3] = corner, line, group, name
                face += 1
                corner += written
            elif error == OK:
                note = FEW_CORNERS
        elif word == _S:
            chosen = _smoothing_group(data, begin, stop)
            note = SMOOTHING if chosen >= 0 else BAD_SMOOTHING
            group = chosen if chosen >= 0 else 0
        elif word == USEMTL or word == MTLLIB:  # noqa: SIM109
            names[name, 0], names[name, 1], names[name, 2], names[name, 3] = word, line, begin, end
            name += 1
        elif word != 0 and word != _O and word != _G:
            _note_word(others, word, line)
        if note >= 0:
            notes[note, 1] = line if notes[note, 0] == 0 else notes[note, 1]
            notes[note, 0] += times
        if error != OK:
            return error, line, word, place, face
        line += lines
    faces[face, 0] = corner
    return OK, line, 0, 0, face
