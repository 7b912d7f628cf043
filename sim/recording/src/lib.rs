//! The MCAP recording of an attempt: write, read, recover, verify, and the loop that simulates one.

pub mod event;
pub mod read;
pub mod recover;
pub mod sample;
pub mod session;
pub mod simulate;
pub mod verify;
pub mod write;

pub use event::{Event, EventKind};
pub use read::{ReadError, Recording};
pub use sample::{Energy, Sample};
pub use session::{Attachment, Session};
pub use write::Writer;
