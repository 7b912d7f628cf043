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
    Tent,
}

impl Topic {
    /// In the order in which a recording declares them. Append only: `recover` numbers channels by it when the
    /// declarations themselves are lost.
    pub(crate) const ALL: [Self; 9] = [
        Self::Sample,
        Self::Summary,
        Self::Pose,
        Self::Tf,
        Self::Scene,
        Self::Events,
        Self::Energy,
        Self::Log,
        Self::Tent,
    ];

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
            Self::Tent => "/tissue/tent",
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
            Self::Tent => return ours("stylet.TissueTent"),
            Self::Pose => PoseInFrame::get_schema(),
            Self::Tf => FrameTransforms::get_schema(),
            Self::Scene => SceneUpdate::get_schema(),
            Self::Log => Log::get_schema(),
        };
        well_known.unwrap_or_else(|| Schema::new("", "", &[][..]))
    }

    /// Whether every recording declares it at its start. The field's is declared with its first message, after all others: a scene
    /// without a field pays nothing for it.
    pub(crate) fn is_always_declared(self) -> bool {
        self != Self::Tent
    }

    /// The topic of a name.
    pub(crate) fn of_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|topic| topic.name() == name)
    }
}

/// Declares a topic; the result is its channel.
pub(crate) fn declare<W: Write + Seek>(writer: &mut mcap::Writer<W>, topic: Topic) -> mcap::McapResult<u16> {
    let schema = topic.schema();
    let schema_id = writer.add_schema(&schema.name, &schema.encoding, &schema.data)?;
    writer.add_channel(schema_id, topic.name(), "protobuf", &BTreeMap::new())
}

/// The file's profile, and the first thing a reader checks.
pub(crate) const PROFILE: &str = "stylet";

/// Largest record that is written or read, in bytes. A file that claims a larger one is damaged.
pub(crate) const MOST_RECORD_BYTES: usize = 64 << 20;
