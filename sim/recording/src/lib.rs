//! The MCAP recording of an attempt: write, read, recover, verify, and the loop that simulates one.

pub mod annotate;
pub mod budget;
pub mod dents;
mod drawing;
pub mod event;
mod frames;
mod metadata;
pub mod motion;
pub mod read;
pub mod recover;
pub mod run;
pub mod sample;
pub mod session;
pub mod signature;
pub mod simulate;
mod summary;
pub mod tables;
pub mod tent;
mod thin;
pub mod tick;
mod topics;
pub mod verify;
mod wire;
pub mod write;

pub use budget::Budget;
pub use dents::Dents;
pub use event::{Event, EventKind};
pub use law::axial::Contactor;
pub use motion::Motion;
pub use read::{ReadError, Recording};
pub use sample::{Energy, Sample};
pub use session::{Attachment, Session};
pub use signature::Signature;
pub use tent::{Follows, Tent};
pub use thin::{keep_extremes, thin};
pub use write::Writer;
