#!/usr/bin/env python3
"""Renders a scene that `export --to mitsuba` wrote by Blender's Cycles.

Needs the Python package `bpy` (pip install bpy, for the Python that it names). `images.py` calls it:

    experiments/peers/blender.py out/room/scene.xml out/room/cycles --spp 256 --seeds 1 8 --settings unbiased

Cycles has no spheres: they become meshes of 256 x 512 faces (lamps 64 x 128) with smooth normals, of the same surface.
"""

import argparse
import math
import os
import pathlib
import sys
import xml.etree.ElementTree

import bpy
import addon_utils  # found once bpy is there
from mathutils import Matrix, Vector

# Faces between the poles of a sphere, and of a shining one: each is a light for Cycles.
STACKS, LAMP_STACKS = 256, 64

# What Blender's manual names as sources of bias, each without it: "Clamping", "Filter Glossy", "Light Threshold",
# "Max Bounces", "Adaptive Sampling" (which stops by the noise that it sees). A box of one pixel as the filter.
UNBIASED = {"sample_clamp_direct": 0, "sample_clamp_indirect": 0, "blur_glossy": 0, "use_adaptive_sampling": False,
            "caustics_reflective": True, "caustics_refractive": True, "pixel_filter_type": "BOX",
            "use_guiding": False} | dict.fromkeys(
                ["max_bounces", "diffuse_bounces", "glossy_bounces", "transmission_bounces",
                 "transparent_max_bounces"], 1024)


def numbers(text):
    return [float(x) for x in text.split(",")]


def value(element, name):
    """The attribute `value` of the child with this name, or None."""
    found = element.find(f"*[@name='{name}']")
    return None if found is None else found.get("value")


def sphere(shape):
    """Corners, faces, and that they are smooth."""
    centre = Vector([float(shape.find("point").get(axis)) for axis in "xyz"])
    inward = value(shape, "flip_normals") == "true"
    stacks = STACKS if shape.find("emitter") is None else LAMP_STACKS
    sectors = 2 * stacks
    corners = [(0, 0, 1)]
    for i in range(1, stacks):
        theta = math.pi * i / stacks
        for j in range(sectors):
            phi = math.tau * j / sectors
            corners.append((math.sin(theta) * math.cos(phi), math.sin(theta) * math.sin(phi), math.cos(theta)))
    corners.append((0, 0, -1))
    ring = lambda i, j: 1 + (i - 1) * sectors + j % sectors
    faces = []
    for j in range(sectors):
        faces.append((0, ring(1, j), ring(1, j + 1)))
        faces.append((len(corners) - 1, ring(stacks - 1, j + 1), ring(stacks - 1, j)))
        for i in range(1, stacks - 1):
            faces.append((ring(i, j), ring(i + 1, j), ring(i + 1, j + 1), ring(i, j + 1)))
    # The polyhedron has less surface than the sphere: it is enlarged by as much.
    area = sum(face_area([Vector(corners[k]) for k in face]) for face in faces)
    radius = float(value(shape, "radius")) * math.sqrt(2 * math.tau / area)
    if inward:
        faces = [face[::-1] for face in faces]
    return [centre + radius * Vector(corner) for corner in corners], faces, True


def face_area(corners):
    """The area of a triangle or a flat quadrilateral."""
    first, *_, last = corners
    return 0.5 * (corners[2] - first).cross(last - corners[1] if len(corners) == 4 else corners[1] - first).length


def obj(path):
    corners, faces = [], []
    for line in path.read_text().splitlines():
        kind, *rest = line.split()
        if kind == "v":
            corners.append([float(x) for x in rest])
        elif kind == "f":
            faces.append([int(x) - 1 for x in rest])
    # The exporter repeats the corners of each triangle. Neighbours share them here: rays cannot pass between.
    places = {}
    index = [places.setdefault(tuple(corner), len(places)) for corner in corners]
    return list(places), [[index[k] for k in face] for face in faces], False


def material(shape):
    found = bpy.data.materials.new("material")
    found.use_nodes = True
    nodes, links = found.node_tree.nodes, found.node_tree.links
    nodes.clear()
    output = nodes.new("ShaderNodeOutputMaterial")
    bsdf = next(x for x in shape.iter("bsdf") if x.get("type") != "twosided")
    if bsdf.get("type") == "diffuse":
        node = nodes.new("ShaderNodeBsdfDiffuse")
        node.inputs["Color"].default_value = (*numbers(value(bsdf, "reflectance")), 1)
    elif bsdf.get("type") == "conductor":
        node = nodes.new("ShaderNodeBsdfGlossy")
        node.inputs["Roughness"].default_value = 0
        node.inputs["Color"].default_value = (*numbers(value(bsdf, "specular_reflectance")), 1)
    elif bsdf.get("type") == "dielectric":
        node = nodes.new("ShaderNodeBsdfGlass")
        node.inputs["Roughness"].default_value = 0
        node.inputs["Color"].default_value = (1, 1, 1, 1)
        node.inputs["IOR"].default_value = float(value(bsdf, "int_ior"))
    else:
        raise SystemExit(f"no material of Cycles for {bsdf.get('type')}")
    surface = node.outputs[0]
    emitter = shape.find("emitter")
    if emitter is not None:
        # One-sided, as an area light of Mitsuba's.
        radiance = numbers(value(emitter, "radiance"))
        emission, geometry, front = (nodes.new(f"ShaderNode{x}") for x in ("Emission", "NewGeometry", "Math"))
        front.operation = "SUBTRACT"
        front.inputs[0].default_value = 1
        links.new(geometry.outputs["Backfacing"], front.inputs[1])
        emission.inputs["Color"].default_value = (*radiance, 1)
        links.new(front.outputs[0], emission.inputs["Strength"])
        total = nodes.new("ShaderNodeAddShader")
        links.new(surface, total.inputs[0])
        links.new(emission.outputs[0], total.inputs[1])
        surface = total.outputs[0]
        found.cycles.emission_sampling = "FRONT"
    links.new(surface, output.inputs["Surface"])
    return found


def camera(sensor, scene):
    lookat = sensor.find("transform/lookat")
    eye, target, up = (Vector(numbers(lookat.get(key))) for key in ("origin", "target", "up"))
    back = (eye - target).normalized()
    right = up.cross(back).normalized()
    up = back.cross(right)
    data = bpy.data.cameras.new("camera")
    data.sensor_fit = "VERTICAL"
    data.angle_y = math.radians(float(value(sensor, "fov")))
    data.clip_start, data.clip_end = float(value(sensor, "near_clip")), float(value(sensor, "far_clip"))
    made = bpy.data.objects.new("camera", data)
    made.matrix_world = Matrix([(*row, e) for row, e in zip(zip(right, up, back), eye)] + [(0, 0, 0, 1)])
    scene.collection.objects.link(made)
    scene.camera = made


def build(path):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    addon_utils.enable("cycles")
    scene = bpy.context.scene
    root = xml.etree.ElementTree.parse(path).getroot()
    camera(root.find("sensor"), scene)
    film = root.find("sensor/film")
    scene.render.resolution_x, scene.render.resolution_y = int(value(film, "width")), int(value(film, "height"))
    scene.render.resolution_percentage = 100
    world = bpy.data.worlds.new("world")
    scene.world = world
    world.use_nodes = True
    sky = root.find("emitter")
    colour = (0, 0, 0) if sky is None else numbers(value(sky, "radiance"))
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (*colour, 1)
    for k, shape in enumerate(root.findall("shape")):
        found = sphere(shape) if shape.get("type") == "sphere" else obj(path.parent / value(shape, "filename"))
        corners, faces, smooth = found
        mesh = bpy.data.meshes.new(f"mesh-{k}")
        mesh.from_pydata(corners, [], faces)
        mesh.polygons.foreach_set("use_smooth", [smooth] * len(mesh.polygons))
        mesh.materials.append(material(shape))
        scene.collection.objects.link(bpy.data.objects.new(f"object-{k}", mesh))
    return scene


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", type=pathlib.Path)
    parser.add_argument("prefix", help="of the images: PREFIX-SEED.exr")
    parser.add_argument("--spp", type=int, default=256)
    parser.add_argument("--seeds", type=int, nargs=2, default=(1, 8), metavar=("FIRST", "LAST"))
    parser.add_argument("--settings", choices=["unbiased", "default", "bounces", "clamp"], default="unbiased",
                        help="Blender's own, or all but one kind of them changed [unbiased]")
    options = parser.parse_args()
    scene = build(options.scene)
    scene.render.engine = "CYCLES"
    scene.cycles.device = "CPU"
    scene.cycles.samples = options.spp
    # Images are compared, not looked at: no denoiser, in either settings.
    scene.cycles.use_denoising = False
    if options.settings != "default":
        for key, setting in UNBIASED.items():
            if options.settings not in key:
                setattr(scene.cycles, key, setting)
        scene.cycles.light_sampling_threshold = 0
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.render.image_settings.color_mode = "RGB"
    # Blender prints each tile: keep its words for errors.
    quiet = os.open(os.devnull, os.O_WRONLY)
    for seed in range(options.seeds[0], options.seeds[1] + 1):
        scene.cycles.seed = seed
        scene.render.filepath = f"{os.path.abspath(options.prefix)}-{seed}.exr"
        sys.stdout.flush()
        kept = os.dup(1)
        os.dup2(quiet, 1)
        bpy.ops.render.render(write_still=True)
        os.dup2(kept, 1)
        os.close(kept)
    print(f"Cycles of Blender {bpy.app.version_string}")


main()
