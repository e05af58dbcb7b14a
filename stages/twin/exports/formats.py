"""The formats, one file each: ENDING, OF (who reads it), CARRIES, `write(exported) -> bytes`.

A format that shows motion takes it as a second argument of `write`; its CARRIES says so. All say the same things of
what they carry, so that formats can be compared.
"""

from types import ModuleType

from stages.twin.exports import gltf, mjcf, sdf, urdf

FORMATS: dict[str, ModuleType] = {"mjcf": mjcf, "urdf": urdf, "sdf": sdf, "gltf": gltf}
