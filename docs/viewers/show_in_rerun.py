"""Shows a recording in Rerun: needle and layers, force, depth, tents and events at once.

    pip install rerun-sdk mcap mcap-protobuf-support
    python docs/viewers/show_in_rerun.py attempt.mcap                      # opens the viewer
    python docs/viewers/show_in_rerun.py attempt.mcap --save attempt.rrd   # a file for `rerun attempt.rrd`

Rerun reads the recording itself: frames, poses and the log. It has no decoder for foxglove.SceneUpdate and no way to know
which fields matter, so this draws what /scene holds, takes the curves from /needle/summary and /tissue/tent, and adds the
blueprint that arranges them. Exit status: 0 done, 1 the file is no such recording, 2 a wrong call.
"""

import argparse
import sys

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

# Rerun names the times of an MCAP file so; what is added here has to lie on the same line.
TIMELINE = "message_log_time"
TOPICS = ["/scene", "/needle/summary", "/tissue/tent"]
MM_PER_M = 1000.0


def vector(v):
    return [v.x, v.y, v.z]


def quaternion(q):
    return rr.Quaternion(xyzw=[q.x, q.y, q.z, q.w])


def colour(c):
    return [c.r, c.g, c.b, c.a]


def draw_cubes(path, cubes):
    shape = rr.Boxes3D(
        centers=[vector(c.pose.position) for c in cubes],
        half_sizes=[[0.5 * size for size in vector(c.size)] for c in cubes],
        quaternions=[quaternion(c.pose.orientation) for c in cubes],
        colors=[colour(c.color) for c in cubes],
        fill_mode=rr.components.FillMode.TransparentFillMajorWireframe,
    )
    rr.log(path, shape, static=True)


def draw_spheres(path, spheres):
    shape = rr.Ellipsoids3D(
        centers=[vector(s.pose.position) for s in spheres],
        half_sizes=[[0.5 * size for size in vector(s.size)] for s in spheres],
        colors=[colour(s.color) for s in spheres],
        fill_mode=rr.components.FillMode.Solid,
    )
    rr.log(path, shape, static=True)


def draw_cylinders(path, cylinders):
    shape = rr.Cylinders3D(
        lengths=[c.size.z for c in cylinders],
        radii=[0.5 * c.size.x for c in cylinders],
        centers=[vector(c.pose.position) for c in cylinders],
        quaternions=[quaternion(c.pose.orientation) for c in cylinders],
        colors=[colour(c.color) for c in cylinders],
        fill_mode=rr.components.FillMode.Solid,
    )
    rr.log(path, shape, static=True)


def draw_triangles(path, meshes):
    points, indices, colours = [], [], []
    for mesh in meshes:
        offset, first = vector(mesh.pose.position), len(points)
        points += [[p + o for p, o in zip(vector(point), offset)] for point in mesh.points]
        indices += [first + index for index in mesh.indices]
        colours += [colour(mesh.color)] * len(mesh.points)
    triangles = [indices[at : at + 3] for at in range(0, len(indices), 3)]
    rr.log(path, rr.Mesh3D(vertex_positions=points, triangle_indices=triangles, vertex_colors=colours), static=True)


def draw_scene(scene):
    """Everything that a foxglove.SceneUpdate holds, each entity in its own frame: the needle's moves."""
    kinds = [("cubes", draw_cubes), ("spheres", draw_spheres), ("cylinders", draw_cylinders), ("triangles", draw_triangles)]
    for entity in scene.entities:
        for kind, draw in kinds:
            primitives = getattr(entity, kind)
            if primitives:
                path = rr.new_entity_path(["drawing", entity.id, kind])
                rr.log(path, rr.CoordinateFrame(entity.frame_id), static=True)
                draw(path, primitives)


def plot(path, times, values, name, colour):
    rr.log(path, rr.SeriesLines(names=name, colors=colour), static=True)
    index = rr.TimeColumn(TIMELINE, timestamp=np.array(times, dtype="datetime64[ns]"))
    rr.send_columns(path, indexes=[index], columns=rr.Scalars.columns(scalars=values))


def plot_summary(times, summaries):
    plot("force/greatest", times, [s.axial_n.max for s in summaries], "greatest in 10 ms", [220, 80, 60])
    plot("force/mean", times, [s.axial_n.mean for s in summaries], "mean", [250, 180, 160])
    plot("depth/tip", times, [MM_PER_M * s.depth_m.mean for s in summaries], "tip", [80, 140, 230])


def plot_tents(times, tents):
    shades = [[230, 180, 60], [120, 200, 110], [180, 120, 210], [90, 190, 200]]
    for boundary in range(len(tents[0].tent_m) if tents else 0):
        values = [MM_PER_M * tent.tent_m[boundary] for tent in tents]
        plot(f"tent/{boundary}", times, values, f"boundary {boundary}", shades[boundary % len(shades)])


def blueprint():
    curves = rrb.Vertical(
        rrb.TimeSeriesView(origin="/force", name="Axial force (N)"),
        rrb.TimeSeriesView(origin="/depth", name="Depth in material (mm)"),
        rrb.TimeSeriesView(origin="/tent", name="Tents (mm)"),
        rrb.TextLogView(origin="/log", name="Events"),
    )
    space = rrb.Spatial3DView(
        name="Needle and layers",
        contents=["/drawing/**", "/tf"],
        spatial_information=rrb.SpatialInformation(target_frame="world"),
        eye_controls=rrb.EyeControls3D(position=[0.16, -0.2, 0.12], look_target=[0.0, 0.0, 0.0], eye_up=[0.0, 0.0, 1.0]),
    )
    return rrb.Blueprint(
        rrb.Horizontal(space, curves),
        rrb.TimePanel(timeline=TIMELINE, state="collapsed"),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
    )


def read(file):
    """Times in ns and messages of each topic that this needs."""
    found = {topic: ([], []) for topic in TOPICS}
    reader = make_reader(file, decoder_factories=[DecoderFactory()])
    for _, channel, message, decoded in reader.iter_decoded_messages(topics=TOPICS):
        times, messages = found[channel.topic]
        times.append(message.log_time)
        messages.append(decoded)
    return found


def show(path, save):
    with open(path, "rb") as file:
        found = read(file)
    scenes, summaries, tents = (found[topic] for topic in TOPICS)
    if not scenes[1]:
        raise SystemExit(f"{path}: it holds no /scene, so it is no recording of Stylet")
    rr.init("stylet", spawn=save is None, default_blueprint=blueprint())
    if save is not None:
        rr.save(save, default_blueprint=blueprint())
    rr.log_file_from_path(path)
    draw_scene(scenes[1][0])
    plot_summary(*summaries)
    plot_tents(*tents)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recording", metavar="ATTEMPT.mcap")
    parser.add_argument("--save", metavar="FILE.rrd", help="write a file instead of opening the viewer")
    arguments = parser.parse_args()
    try:
        show(arguments.recording, arguments.save)
    except (McapError, OSError) as error:
        sys.exit(f"{arguments.recording}: {error}")
