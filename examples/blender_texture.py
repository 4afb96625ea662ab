"""Makes a texture of microbrdf's a material of Blender's Principled BSDF:

  blender -b --factory-startup -P examples/blender_texture.py -- texture/texture.h5 metal

leaves metal.blend, with the material on a plane of the texture's own size in metres, and metal_roughness.exr,
metal_anisotropy.exr, metal_rotation.exr, metal_normal.exr beside it. Row 0 of the texture lies at v = 0.
Needs h5py and numpy in Blender's Python (Debian: python3-h5py). Blender 3.4, Cycles.
"""
import os
import sys

import bpy
import h5py
import numpy as np


def maps_of(parameters):
    """Roughness, anisotropy, rotation in turns, and normal map from alpha.x, alpha.y, theta.x, theta.y, theta.z.

    An ellipsoid is an anisotropic GGX about N = R'z, tangents the first two rows of R = Rx Ry Rz [Dong15 Eq. 12].
    Cycles: alpha = roughness^2, alpha_x = alpha/aspect, alpha_y = alpha aspect, aspect^2 = 1 - 0.9 anisotropy;
    so lobes of more than 10:1 are drawn as 10:1."""
    ax, ay, x, y, z = np.moveaxis(parameters.astype(float), -1, 0)
    tangent = np.stack([np.cos(y) * np.cos(z), -np.cos(y) * np.sin(z)])
    normal = np.stack([np.sin(x) * np.sin(z) - np.cos(x) * np.sin(y) * np.cos(z),
                       np.sin(x) * np.cos(z) + np.cos(x) * np.sin(y) * np.sin(z),
                       np.cos(x) * np.cos(y)], -1)
    return {"roughness": (ax * ay) ** 0.25,
            "anisotropy": np.minimum(1, (1 - ay / ax) / 0.9),
            "rotation": np.arctan2(tangent[1], tangent[0]) / (2 * np.pi) % 1,
            "normal": 0.5 + 0.5 * normal}


def image_of(path, values):
    rows, cols = values.shape[:2]
    image = bpy.data.images.new(os.path.basename(path), cols, rows, float_buffer=True, is_data=True)  # is_data: Non-Color
    pixels = np.ones((rows, cols, 4), np.float32)
    pixels[..., :3] = values if values.ndim == 3 else values[..., None]
    image.pixels.foreach_set(pixels.ravel())
    image.filepath_raw, image.file_format = path + ".exr", "OPEN_EXR"
    image.save()
    return image


def material_of(path, maps):
    material = bpy.data.materials.new(os.path.basename(path))
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    principled = nodes["Principled BSDF"]
    principled.distribution = "GGX"
    principled.inputs["Metallic"].default_value = 1
    tangent = nodes.new("ShaderNodeTangent")
    tangent.direction_type, tangent.uv_map = "UV_MAP", "UVMap"
    links.new(tangent.outputs["Tangent"], principled.inputs["Tangent"])
    outputs = {}
    for kind, values in maps.items():
        node = nodes.new("ShaderNodeTexImage")
        node.image, node.interpolation = image_of(f"{path}_{kind}", values), "Closest"  # rotations wrap
        outputs[kind] = node.outputs["Color"]
    bump = nodes.new("ShaderNodeNormalMap")
    bump.uv_map = "UVMap"
    links.new(outputs["normal"], bump.inputs["Color"])
    links.new(bump.outputs["Normal"], principled.inputs["Normal"])
    for kind, socket in (("roughness", "Roughness"), ("anisotropy", "Anisotropic"), ("rotation", "Anisotropic Rotation")):
        links.new(outputs[kind], principled.inputs[socket])
    return material


def plane_of(name, width, height, material):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([(0, 0, 0), (width, 0, 0), (width, height, 0), (0, height, 0)], [], [(0, 1, 2, 3)])
    layer = mesh.uv_layers.new(name="UVMap")
    for corner, uv in zip(layer.data, ((0, 0), (1, 0), (1, 1), (0, 1))):
        corner.uv = uv
    mesh.materials.append(material)
    plane = bpy.data.objects.new(name, mesh)
    bpy.context.collection.objects.link(plane)
    return plane


def load(source, path):
    """A plane of the texture in a file, its images beside `path`."""
    with h5py.File(source) as file:
        texture = file["texture"]
        maps = maps_of(texture["parameters"][:])
        rows, cols = maps["roughness"].shape
        size = cols * texture.attrs["texel_width_um"] * 1e-6, rows * texture.attrs["texel_height_um"] * 1e-6
    return plane_of(os.path.basename(path), *size, material_of(path, maps))


if __name__ == "__main__" and "--" in sys.argv:
    source, path = map(os.path.abspath, sys.argv[sys.argv.index("--") + 1:])
    bpy.context.scene.render.engine = "CYCLES"
    load(source, path)
    bpy.ops.wm.save_as_mainfile(filepath=path + ".blend")
