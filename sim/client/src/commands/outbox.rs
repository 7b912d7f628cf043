//! `stylet outbox`: lists pending deliveries and their errors.

use std::path::PathBuf;
use std::time::Duration;

use clap::Subcommand;
use serde::Serialize;
use time::OffsetDateTime;
use time::format_description::well_known::Rfc3339;
use ureq::http::Uri;

use super::upload::{self, PatienceArgs};
use crate::exit::{Failure, Outcome};
use crate::outbox::{Access, Entry, Outbox, Patience, Post};
use crate::station::Pairing;
use crate::{clock, output, service};

/// Interval at which `--watch` checks for new attempts and for due ones.
const WATCH_EVERY: Duration = Duration::from_secs(2);

/// List pending deliveries and their errors
///
/// Attempts, and answers to a school's questions after them, wait in a folder until the service
/// confirms that they are stored. Each is retried after a wait that doubles after each failure, up
/// to a quarter of an hour; deliveries that the service rejects permanently stay, with the reason,
/// until they are discarded.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  stylet outbox\n  stylet outbox send --watch\n  stylet outbox discard 3f2a9c0b12d4e5f6"
)]
pub struct OutboxArgs {
    #[command(subcommand)]
    command: Option<OutboxCommand>,
    /// Folder of the outbox [default: the user's own]
    #[arg(long, value_name = "DIR", env = "STYLET_OUTBOX", global = true)]
    outbox: Option<PathBuf>,
    /// Print the result as JSON
    #[arg(long, global = true)]
    json: bool,
}

#[derive(Subcommand)]
enum OutboxCommand {
    Send(SendArgs),
    Discard(DiscardArgs),
}

/// Send pending deliveries now
///
/// Tries all pending deliveries, including those that are not due yet; rejected ones only if their
/// id is given.
#[derive(clap::Args)]
struct SendArgs {
    /// Ids of attempts, including rejected ones; by default all pending ones
    #[arg(value_name = "ID")]
    ids: Vec<String>,
    /// Keep running and send new attempts, each when it is due
    #[arg(long, conflicts_with = "ids")]
    watch: bool,
    /// Address of a service other than the paired one
    #[arg(long, value_name = "URL", value_parser = service::parse_server_address)]
    server: Option<Uri>,
    /// File that contains the bearer token for --server
    #[arg(long, value_name = "F", requires = "server")]
    token_file: Option<PathBuf>,
    #[command(flatten)]
    patience: PatienceArgs,
}

/// Delete attempts from the outbox without delivering them
#[derive(clap::Args)]
struct DiscardArgs {
    /// Ids of the attempts
    #[arg(value_name = "ID", required = true)]
    ids: Vec<String>,
}

/// Runs the command.
pub fn run(args: &OutboxArgs) -> Outcome {
    let outbox = Outbox::open(args.outbox.as_deref())?;
    match &args.command {
        None => list(&outbox, args.json),
        Some(OutboxCommand::Send(send)) if send.watch => watch(&outbox, send, args.json),
        Some(OutboxCommand::Send(send)) => send_now(&outbox, send, args.json),
        Some(OutboxCommand::Discard(discard)) => {
            for entry in named(&outbox, &discard.ids)? {
                entry.remove().map_err(|error| Failure::work(format_args!("{}: {error}", entry.file.display())))?;
                output::print_line(format_args!("{}: discarded", entry.note.name))?;
            }
            Ok(())
        }
    }
}

/// A pending attempt, for JSON output.
#[derive(Serialize)]
struct Waiting<'a> {
    id: &'a str,
    name: &'a str,
    file: String,
    bytes: u64,
    kept_at: String,
    /// `None` for the service with which this station is paired.
    server: Option<&'a str>,
    /// `waiting` or `refused`.
    state: &'static str,
    tries: u32,
    last_error: Option<&'a str>,
    next_try_at: Option<String>,
}

impl<'a> From<&'a Entry> for Waiting<'a> {
    fn from(entry: &'a Entry) -> Self {
        Self {
            id: &entry.id,
            name: &entry.note.name,
            file: entry.file.display().to_string(),
            bytes: entry.bytes,
            kept_at: rfc3339(entry.note.kept_at),
            server: entry.note.server.as_deref(),
            state: if entry.note.refused { "refused" } else { "waiting" },
            tries: entry.note.tries,
            last_error: entry.note.last_error.as_deref(),
            next_try_at: entry.note.next_try_at.map(rfc3339),
        }
    }
}

fn rfc3339(at: OffsetDateTime) -> String {
    at.replace_nanosecond(0).unwrap_or(at).format(&Rfc3339).unwrap_or_default()
}

fn list(outbox: &Outbox, json: bool) -> Outcome {
    let entries = outbox.entries()?;
    if json {
        return output::print_json(&entries.iter().map(Waiting::from).collect::<Vec<_>>());
    }
    if entries.is_empty() {
        return output::print_line(format_args!("no pending attempts in {}", outbox.folder().display()));
    }
    entries.iter().try_for_each(|entry| {
        let Waiting { id, name, bytes, kept_at, state, .. } = Waiting::from(entry);
        let megabytes = bytes as f64 * 1e-6;
        let why = output::one_line(&why(entry));
        output::print_line(format_args!("{id}  {name}  {megabytes:.1} MB  since {kept_at}  {state}: {why}"))
    })
}

fn why(entry: &Entry) -> String {
    let note = &entry.note;
    match (&note.last_error, note.next_try_at) {
        (None, _) => "not sent yet".to_owned(),
        (Some(error), None) => format!("{error} (tries: {})", note.tries),
        (Some(error), Some(at)) => format!("{error} (tries: {}, next at {})", note.tries, rfc3339(at)),
    }
}

/// The entries with the given ids; an unknown id is an error.
fn named(outbox: &Outbox, ids: &[String]) -> Result<Vec<Entry>, Failure> {
    let entries = outbox.entries()?;
    let find = |id: &String| {
        let found = entries.iter().find(|entry| entry.id == *id).cloned();
        found.ok_or_else(|| Failure::input(format_args!("{id}: no such attempt in {}", outbox.folder().display())))
    };
    ids.iter().map(find).collect()
}

fn access(args: &SendArgs) -> Result<Access, Failure> {
    let named = args.server.as_ref().map(|server| upload::named_service(server, args.token_file.as_deref()));
    Ok(Access::new(named.transpose()?, Pairing::load()?.as_ref()))
}

fn send_now(outbox: &Outbox, args: &SendArgs, json: bool) -> Outcome {
    let access = access(args)?;
    let post = Post::open(outbox, &access, Patience::from(&args.patience))?;
    let mut entries = match args.ids.as_slice() {
        [] => outbox.entries()?.into_iter().filter(|entry| !entry.note.refused).collect(),
        ids => named(outbox, ids)?,
    };
    let deliveries: Result<Vec<_>, Failure> = entries.iter_mut().map(|entry| post.send(entry)).collect();
    upload::report(&deliveries?, outbox, json)
}

/// Sends due attempts until it is stopped. Errors are reported and retried.
fn watch(outbox: &Outbox, args: &SendArgs, json: bool) -> Outcome {
    loop {
        // Read each time: the station may have been paired again meanwhile.
        let due = outbox.entries()?.iter().any(|entry| entry.is_due(clock::now()));
        if due {
            let deliveries = outbox.send_due(&access(args)?, Patience::from(&args.patience))?;
            match upload::report(&deliveries, outbox, json) {
                Ok(()) | Err(Failure::Found) => {}
                ended => return ended,
            }
        }
        std::thread::sleep(WATCH_EVERY);
    }
}
