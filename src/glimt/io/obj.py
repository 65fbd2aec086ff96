"""OBJ files to meshes."""

import os
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from glimt.errors import GlimtError, WarningCounter
from glimt.io.image import TextureCache
from glimt.io.mtl import read_mtl
from glimt.io.obj_parser import ABSENT
from glimt.io.obj_paths import FileFinder
from glimt.io.obj_text import Name, ObjText, parse_text, read_bytes, without_comment
from glimt.io.smooth import smooth_normals, unique_rows
from glimt.io.triangulate import Triangles, has_area, triangulate
from glimt.scene import checks
from glimt.scene.material import Material
from glimt.scene.mesh import Mesh

MAX_LIBRARIES = 1000
"""Names of MTL files in an OBJ file."""


def read_obj(path: str | os.PathLike[str], *, warnings: WarningCounter | None = None,
             textures: TextureCache | None = None) -> Mesh:
    """Read an OBJ file, its MTL files and their textures as one mesh.

    Polygons become triangles, concave ones too. Corners that agree in position, texcoord and normal are one vertex.
    Where the file gives no normal it is computed: by smoothing groups, or in a file that has none by the angle between
    faces. Texcoords are turned over to have their origin at the top left.

    Parameters
    ----------
    path : str or path
        At most 4 GiB. What the file refers to must lie below the folder above it (see `obj_paths`).
    warnings : WarningCounter, optional
        Receives what was dropped, replaced or ignored; without one, it is issued at the end.
    textures : TextureCache, optional
        Shared by the files of one load, so that an image is decoded once.

    Raises
    ------
    GlimtError
        The file cannot be read or has no triangle; a statement is wrong, with its line.
    """
    path = Path(path)
    counter = WarningCounter() if warnings is None else warnings
    try:
        text = parse_text(read_bytes(path), path, counter)
        mesh = _build(text, path, counter, textures or TextureCache())
    except MemoryError:
        raise GlimtError(f"{path}: is too large for this computer's memory; split it") from None
    if warnings is None:
        counter.issue()
    return mesh


def _build(text: ObjText, path: Path, warnings: WarningCounter, textures: TextureCache) -> Mesh:
    if not len(text.lines):
        raise GlimtError(f"{path}: has no faces, and nothing else is drawn; export the mesh with its faces")
    triangles = _triangles(text, path, warnings)
    corners = text.corners[triangles.corners]
    normals = _with_normals(text, triangles.faces, corners)
    ids, firsts = unique_rows(corners.reshape(-1, 3))
    vertices = corners.reshape(-1, 3)[firsts]
    materials, material_ids = _materials(text, path, warnings, textures)
    used, triangle_materials = np.unique(material_ids[triangles.faces], return_inverse=True)
    return Mesh(text.positions[vertices[:, 0]], ids.reshape(-1, 3), normals[vertices[:, 2]],
                _texcoords(text.texcoords, vertices[:, 1]), [materials[i] for i in used],
                triangle_materials.astype(np.int32), path.stem)


def _triangles(text: ObjText, path: Path, warnings: WarningCounter) -> Triangles:
    """Cut the faces; drop and count triangles that have no area."""
    triangles = triangulate(text.positions[text.corners[:, 0]], text.starts)
    if not triangles.complete:
        warnings.add("concave faces have too many corners to be cut well; they may overlap themselves", str(path))
    kept = has_area(text.positions, text.corners[:, 0][triangles.corners])
    if not kept.any():
        raise GlimtError(f"{path}:{text.lines[0]}: none of the {len(kept)} triangles has an area")
    dropped = np.flatnonzero(~kept)
    if len(dropped):
        line = text.lines[triangles.faces[dropped[0]]]
        warnings.add("a triangle without area is dropped", f"{path}:{line}", len(dropped))
    return Triangles(triangles.corners[kept], triangles.faces[kept], triangles.complete)


def _with_normals(text: ObjText, faces: NDArray[np.int64],
                  corners: NDArray[np.int32]) -> NDArray[np.float32]:
    """Return all normals; corners (m, 3, 3) without a usable one of the file's are pointed to one that is computed."""
    usable = np.asarray((np.abs(text.normals) <= checks.LARGEST).all(1) & text.normals.any(1))
    missing = corners[..., 2] == ABSENT
    missing[~missing] = ~usable[corners[~missing][:, 2]]
    if not missing.any():
        return text.normals
    groups = text.groups[faces] if text.smoothing else None
    labels, computed = smooth_normals(text.positions, np.ascontiguousarray(corners[..., 0]), faces, groups)
    corners[..., 2] = np.where(missing, labels + len(text.normals), corners[..., 2])
    return np.concatenate([text.normals, computed])


def _texcoords(texcoords: NDArray[np.float32], ids: NDArray[np.int32]) -> NDArray[np.float32] | None:
    """Return texcoords of vertices with the origin at the top left, (0, 0) where a vertex has none."""
    if (ids == ABSENT).all():
        return None
    table = np.concatenate([texcoords, np.array([[0, 1]], np.float32)])  # ABSENT is the 0 0 at the end
    table[:, 1] = 1 - table[:, 1]
    return table[ids]


def _materials(text: ObjText, path: Path, warnings: WarningCounter,
               textures: TextureCache) -> tuple[list[Material], NDArray[np.int64]]:
    """Return the materials and the index of one for each face; the first is the default."""
    library = _read_libraries(text, path, warnings, textures)
    by_name = {without_comment(name): material for name, material in library.items()} | library
    materials, index_of = [Material(name="default")], {}
    for statement in text.materials:
        if statement.text in index_of:
            continue
        material = by_name.get(statement.text) or by_name.get(without_comment(statement.text))
        if material is None:
            warnings.add(f"there is no material {statement.text!r}; the default is used", f"{path}:{statement.line}")
            index_of[statement.text] = 0
        else:
            index_of[statement.text] = len(materials)
            materials.append(material)
    indices = np.array([index_of[statement.text] for statement in text.materials] + [0])
    return materials, indices[text.uses]  # use -1, none yet, is the 0 at the end


def _read_libraries(text: ObjText, path: Path, warnings: WarningCounter,
                    textures: TextureCache) -> dict[str, Material]:
    """Read the materials in use, each MTL file once; a name that several define means the last."""
    finder, statements = FileFinder(), text.libraries
    used = {name for use in text.materials for name in (use.text, without_comment(use.text))}
    library: dict[str, Material] = {}
    read: set[Path] = set()
    if sum(len(statement.text.split()) for statement in statements) > MAX_LIBRARIES:
        raise GlimtError(f"{path}:{statements[0].line}: names more than {MAX_LIBRARIES} MTL files; join them")
    for statement in statements:
        for file in _library_files(statement, path, finder, warnings):
            if file in read:
                continue
            read.add(file)
            materials = read_mtl(file, warnings, textures, used)
            if library.keys() & materials.keys():
                warnings.add("a material of an earlier MTL file is defined again; the last one is used", str(file))
            library |= materials
    return library


def _library_files(statement: Name, path: Path, finder: FileFinder, warnings: WarningCounter) -> list[Path]:
    """Return the files a `mtllib` names: the whole rest of the line is one name, or else each word of it is."""
    several = statement.text.lower().count(".mtl") > 1
    for whole in (statement.text, without_comment(statement.text)):
        file = finder.find(whole, path.parent, beside=not several)
        if file is not None:
            return [file]
    files = []
    for name in without_comment(statement.text).split():
        file = finder.find(name, path.parent)
        if file is not None:
            files.append(file)
        else:
            warnings.add(f"there is no MTL file {name!r}; its materials are left out", f"{path}:{statement.line}")
    return files
