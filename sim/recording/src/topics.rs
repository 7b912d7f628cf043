//! The topics of a recording: name, schema, and the fixed order that gives each its channel number.

use std::collections::BTreeMap;
use std::io::{Seek, Write};

use foxglove::schemas::{FrameTransforms, Log, PoseInFrame, SceneUpdate};
use foxglove::{Encode, Schema};

use crate::wire::DESCRIPTORS;

/// A topic. Its number is its place in [`Topic::ALL`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Topic {
    Sample,
    Summary,
    Pose,
    Tf,
    Scene,
    Events,
    Energy,
    Log,
}

impl Topic {
    /// In the order in which a recording declares them. Append only: `recover` numbers channels by it when the
    /// declarations themselves are lost.
    pub(crate) const ALL: [Self; 8] =
        [Self::Sample, Self::Summary, Self::Pose, Self::Tf, Self::Scene, Self::Events, Self::Energy, Self::Log];

    /// The topic's name.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Sample => "/needle/sample",
            Self::Summary => "/needle/summary",
            Self::Pose => "/needle/pose",
            Self::Tf => "/tf",
            Self::Scene => "/scene",
            Self::Events => "/events",
            Self::Energy => "/needle/energy",
            Self::Log => "/log",
        }
    }

    /// The schema of its messages.
    pub(crate) fn schema(self) -> Schema {
        let ours = |name: &str| Schema::new(name, "protobuf", DESCRIPTORS);
        let well_known = match self {
            Self::Sample => return ours("stylet.NeedleSample"),
            Self::Summary => return ours("stylet.NeedleSummary"),
            Self::Events => return ours("stylet.Event"),
            Self::Energy => return ours("stylet.EnergyLedger"),
            Self::Pose => PoseInFrame::get_schema(),
            Self::Tf => FrameTransforms::get_schema(),
            Self::Scene => SceneUpdate::get_schema(),
            Self::Log => Log::get_schema(),
        };
        well_known.unwrap_or_else(|| Schema::new("", "", &[][..]))
    }

    /// The topic of a name.
    pub(crate) fn of_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|topic| topic.name() == name)
    }
}

/// Declares every topic; the result is each one's channel, by its place in [`Topic::ALL`].
pub(crate) fn declare<W: Write + Seek>(writer: &mut mcap::Writer<W>) -> mcap::McapResult<[u16; Topic::ALL.len()]> {
    let mut channels = [0; Topic::ALL.len()];
    for (channel, topic) in channels.iter_mut().zip(Topic::ALL) {
        let schema = topic.schema();
        let schema_id = writer.add_schema(&schema.name, &schema.encoding, &schema.data)?;
        *channel = writer.add_channel(schema_id, topic.name(), "protobuf", &BTreeMap::new())?;
    }
    Ok(channels)
}
