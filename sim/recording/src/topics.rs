//! The topics of a recording: name, schema, and the fixed order that defines their channel numbers.

use std::collections::BTreeMap;
use std::io::{Seek, Write};

use crate::wire::DESCRIPTORS;

/// A topic. Its number is its index in [`Topic::ALL`].
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
    CArm,
    Fluoroscopy,
}

impl Topic {
    /// Every topic, in the order in which a recording declares them. Append only: `recover` numbers
    /// channels by it if the declarations are lost.
    pub(crate) const ALL: [Self; 11] = [
        Self::Sample,
        Self::Summary,
        Self::Pose,
        Self::Tf,
        Self::Scene,
        Self::Events,
        Self::Energy,
        Self::Log,
        Self::Tent,
        Self::CArm,
        Self::Fluoroscopy,
    ];

    /// Returns the topic's name.
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
            Self::CArm => "/c_arm",
            Self::Fluoroscopy => "/fluoroscopy",
        }
    }

    /// Returns the type name of its messages.
    pub(crate) fn message_name(self) -> &'static str {
        match self {
            Self::Sample => "stylet.NeedleSample",
            Self::Summary => "stylet.NeedleSummary",
            Self::Pose => "foxglove.PoseInFrame",
            Self::Tf => "foxglove.FrameTransforms",
            Self::Scene => "foxglove.SceneUpdate",
            Self::Events => "stylet.Event",
            Self::Energy => "stylet.EnergyLedger",
            Self::Log => "foxglove.Log",
            Self::Tent => "stylet.TissueTent",
            Self::CArm => "stylet.CArmControls",
            Self::Fluoroscopy => "stylet.FluoroscopyPulse",
        }
    }

    /// Returns the `FileDescriptorSet` of its messages.
    fn descriptors(self) -> &'static [u8] {
        match self {
            Self::Sample
            | Self::Summary
            | Self::Events
            | Self::Energy
            | Self::Tent
            | Self::CArm
            | Self::Fluoroscopy => DESCRIPTORS,
            Self::Pose => include_bytes!("../proto/foxglove/PoseInFrame.bin"),
            Self::Tf => include_bytes!("../proto/foxglove/FrameTransforms.bin"),
            Self::Scene => include_bytes!("../proto/foxglove/SceneUpdate.bin"),
            Self::Log => include_bytes!("../proto/foxglove/Log.bin"),
        }
    }

    /// Returns whether every recording declares it at its start. The topics of field and fluoroscopy are declared with
    /// their first message, after all others, so that a scene without these has no overhead.
    pub(crate) fn is_always_declared(self) -> bool {
        (self as usize) < Self::Tent as usize
    }

    /// Returns the topic with this name.
    pub(crate) fn of_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|topic| topic.name() == name)
    }
}

/// Declares a topic and returns its channel id.
pub(crate) fn declare<W: Write + Seek>(writer: &mut mcap::Writer<W>, topic: Topic) -> mcap::McapResult<u16> {
    let schema_id = writer.add_schema(topic.message_name(), "protobuf", topic.descriptors())?;
    writer.add_channel(schema_id, topic.name(), "protobuf", &BTreeMap::new())
}

/// The file's profile, checked first by readers.
pub(crate) const PROFILE: &str = "stylet";

/// Maximum size of a record, in bytes. A file that claims a larger one is damaged.
pub(crate) const MOST_RECORD_BYTES: usize = 64 << 20;
