"""Checks that what is shipped for viewers finds in a recording what it names, by the schemas that the recording itself carries.

    pip install mcap mcap-protobuf-support
    python tests/python/check_viewers.py ATTEMPT.mcap

The layout for Lichtblick and Foxglove: every topic and message path leads to something. The script for Rerun: it runs to its
end with stand-ins for Rerun and numpy, and hands over curves and shapes that are the recording's own. Exit status: 0 so, 1 not so.
"""

import importlib.util
import json
import re
import sys
from pathlib import Path
from unittest import mock

from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

VIEWERS = Path(__file__).resolve().parents[2] / "docs" / "viewers"
# Panels and the schemas whose topics they can show; another kind of panel needs a line here.
PANELS = {"3D", "Plot", "StateTransitions", "RosOut"}
IN_SPACE = {"foxglove.SceneUpdate", "foxglove.PoseInFrame", "foxglove.FrameTransforms"}


def check(good, words):
    if not good:
        raise SystemExit(f"not as it should be: {words}")


def read(path):
    """Schema and messages of each topic."""
    found = {}
    with open(path, "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        for schema, channel, _, decoded in reader.iter_decoded_messages():
            found.setdefault(channel.topic, (schema.name, []))[1].append(decoded)
    return found


def follow(message, steps):
    """The value at a message path, for example ["axial_n", "max"] or ["tent_m[0]"]."""
    for step in steps:
        name, index = re.fullmatch(r"(\w+)(?:\[(\d+)\])?", step).groups()
        check(name in message.DESCRIPTOR.fields_by_name, f"{message.DESCRIPTOR.full_name} has no field {name}")
        message = getattr(message, name)
        if index is not None:
            check(int(index) < len(message), f"{name} has {len(message)} entries, wanted is {index}")
            message = message[int(index)]
    return message


def paths(panel):
    """The message paths that a panel names."""
    return [path["value"] for path in panel.get("paths", [])]


def panels(layout):
    """The panels of an arrangement, from its leaves."""
    if isinstance(layout, str):
        return {layout}
    return panels(layout["first"]) | panels(layout["second"])


def check_layout(found):
    layout = json.loads((VIEWERS / "lichtblick-layout.json").read_text())
    configured = layout["configById"]
    check(panels(layout["layout"]) == configured.keys(), "panels that are arranged are not those that are configured")
    frames = {t.parent_frame_id for m in found["/tf"][1] for t in m.transforms} | {
        t.child_frame_id for m in found["/tf"][1] for t in m.transforms
    }
    used = set()
    for name, panel in configured.items():
        check(name.split("!")[0] in PANELS, f"panel {name}")
        for topic in panel.get("topics", {}):
            check(found[topic][0] in IN_SPACE, f"{topic} cannot be shown in space")
            used.add(topic)
        if "followTf" in panel:
            check(panel["followTf"] in frames, f"frame {panel['followTf']} is none of {frames}")
            check(panel["topics"]["/scene"]["visible"], "/scene is off")
            check(panel["cameraState"]["near"] < 0.1 * panel["cameraState"]["distance"] < 0.1, "the camera is not near")
        for frame in panel.get("transforms", {}):
            check(frame.removeprefix("frame:") in frames, f"{frame} is none of {frames}")
        if "topicToRender" in panel:
            check(found[panel["topicToRender"]][0] == "foxglove.Log", f"{panel['topicToRender']} is no log")
            used.add(panel["topicToRender"])
        for path in paths(panel):
            topic, *steps = path.split(".")
            check(topic in found and steps, f"{path}: topics are {sorted(found)}")
            value = follow(found[topic][1][0], steps)
            check(isinstance(value, (int, float, str)), f"{path} leads to {value!r}")
            used.add(topic)
    wanted = {"/scene", "/needle/summary", "/tissue/tent", "/events", "/log"}
    check(wanted <= used, f"the layout does not show {wanted - used}")


def check_rerun(path, found):
    rerun = mock.MagicMock()
    rerun.new_entity_path.side_effect = "/".join
    rerun.Scalars.columns.side_effect = lambda scalars: scalars
    numpy = mock.MagicMock()
    numpy.array.side_effect = lambda values, dtype: values
    modules = {"rerun": rerun, "rerun.blueprint": rerun.blueprint, "numpy": numpy}
    with mock.patch.dict(sys.modules, modules):
        spec = importlib.util.spec_from_file_location("show_in_rerun", VIEWERS / "show_in_rerun.py")
        script = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(script)
        script.show(path, "nowhere.rrd")
    curves = {call.args[0]: call.kwargs["columns"] for call in rerun.send_columns.call_args_list}
    summaries, tents = found["/needle/summary"][1], found["/tissue/tent"][1]
    check(curves["force/greatest"] == [s.axial_n.max for s in summaries], "force is not the recording's")
    check(curves["depth/tip"] == [1000 * s.depth_m.mean for s in summaries], "depth is not the recording's")
    for boundary in range(len(tents[0].tent_m)):
        check(curves[f"tent/{boundary}"] == [1000 * t.tent_m[boundary] for t in tents], f"tent {boundary}")
    entities = found["/scene"][1][0].entities
    drawn = {call.args[0] for call in rerun.log.call_args_list}
    for entity in entities:
        check(any(entity.id in place for place in drawn), f"{entity.id} is not drawn")
    frames = {call.args[0] for call in rerun.CoordinateFrame.call_args_list}
    check(frames == {entity.frame_id for entity in entities}, f"frames {frames}")
    views = {call.kwargs["origin"] for call in rerun.blueprint.TimeSeriesView.call_args_list}
    check(all(any(f"/{place}".startswith(view) for place in curves) for view in views), f"a view without a curve: {views}")
    check(rerun.blueprint.TextLogView.call_args.kwargs["origin"] in found, "a log that is not there")
    rerun.log_file_from_path.assert_called_once_with(path)


if __name__ == "__main__":
    recording = sys.argv[1]
    messages = read(recording)
    check_layout(messages)
    check_rerun(recording, messages)
    print(f"{recording}: the layout and the script for Rerun find all that they name")
