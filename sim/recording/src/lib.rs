//! The MCAP recording of an attempt: file format only. Writes, reads, recovers and annotates
//! recordings, and converts them to tables.

pub mod annotate;
pub mod budget;
mod drawing;
pub mod error;
pub mod event;
pub mod fluoroscopy;
mod frames;
mod generated;
mod metadata;
pub mod motion;
pub mod rate;
pub mod read;
pub mod recover;
pub mod sample;
pub mod session;
pub mod signature;
mod summary;
pub mod tables;
pub mod tent;
mod thin;
mod topics;
mod wire;
pub mod write;

pub use budget::Budget;
pub use error::{ReadError, WriteError};
pub use event::{Event, EventKind};
pub use fluoroscopy::{CArmControls, Fluoroscopy, FluoroscopyPulse};
pub use law::axial::Contactor;
pub use motion::{AttemptHashes, ConditionsDigest, MotionDigest};
pub use read::Recording;
pub use sample::{Energy, Sample};
pub use session::{Attachment, Session};
pub use signature::Signature;
pub use tent::{Follows, Tent};
pub use thin::keep_extremes;
pub use write::Writer;
