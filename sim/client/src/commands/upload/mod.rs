//! `stylet upload`: recordings to the service.

mod delivery;

use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::builder::RangedU64ValueParser;
use ureq::http::{HeaderValue, Uri};

use crate::exit::{Failure, Outcome};
use crate::{commands, output};
use delivery::{Delivery, Service};

/// Send recordings to a service
///
/// A recording counts as delivered when the service says that it is on its disk (201), or that it already was (200).
/// Network errors and a busy or failing service are tried again, waiting twice as long each time. The token comes from
/// --token-file or the environment variable STYLET_TOKEN, never from the command line, which other users can see.
#[derive(clap::Args)]
#[command(
    after_help = "Example:\n  stylet upload *.mcap --server https://training.example.org --token-file ~/.stylet-token"
)]
pub struct Args {
    /// The recordings
    #[arg(value_name = "REC.mcap", required = true)]
    recordings: Vec<PathBuf>,
    /// Address of the service, http or https
    #[arg(long, value_name = "URL", value_parser = server)]
    server: Uri,
    /// File holding the bearer token
    #[arg(long, value_name = "F")]
    token_file: Option<PathBuf>,
    /// How often to try again after a network error or a failing service
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = RangedU64ValueParser::<u32>::new().range(0..=20))]
    retries: u32,
    /// Wait before the first new try, in ms; doubled each time, up to a minute
    #[arg(long, value_name = "MS", default_value_t = 500, value_parser = RangedU64ValueParser::<u64>::new().range(1..=60_000))]
    retry_wait_ms: u64,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(args: &Args) -> Outcome {
    for recording in &args.recordings {
        commands::open(recording)?;
    }
    let token = token(args.token_file.as_deref())?;
    if sends_in_the_clear(&args.server) {
        output::warning(format_args!(
            "{}: http is not encrypted: others on the network can read the token",
            args.server
        ));
    }
    let wait = Duration::from_millis(args.retry_wait_ms);
    let service = Service::new(&args.server, token, args.retries, wait);
    let mut deliveries = Vec::new();
    for recording in &args.recordings {
        let delivery = service.deliver(recording);
        match (delivery.delivered, args.json) {
            (true, false) => said(&delivery)?,
            (true, true) => {}
            (false, _) => output::error(format_args!("{}: not delivered: {}", delivery.recording, delivery.detail)),
        }
        deliveries.push(delivery);
    }
    if args.json {
        output::json(&deliveries)?;
    }
    if deliveries.iter().all(|delivery| delivery.delivered) { Ok(()) } else { Err(Failure::Found) }
}

fn said(delivery: &Delivery) -> Outcome {
    output::line(format_args!("{}: delivered: {}", delivery.recording, delivery.detail))
}

/// An address with a scheme and a host, to which `/api/v1/…` can be added.
pub fn server(text: &str) -> Result<Uri, String> {
    let uri: Uri =
        text.parse().map_err(|error| format!("{error}; an address such as https://example.org is allowed"))?;
    match (uri.scheme_str(), uri.host(), uri.query()) {
        (Some("http" | "https"), Some(_), None) => Ok(uri),
        _ => Err("http://HOST or https://HOST, optionally with :PORT and a path, is allowed".to_owned()),
    }
}

/// A bearer token that leaves this machine unencrypted.
fn sends_in_the_clear(server: &Uri) -> bool {
    let local = matches!(server.host(), Some("localhost" | "127.0.0.1" | "[::1]"));
    server.scheme_str() == Some("http") && !local
}

/// The token as a header value. Its text is never printed.
fn token(file: Option<&Path>) -> Result<HeaderValue, Failure> {
    let (place, text) = match file {
        Some(path) => (path.display().to_string(), commands::read_text(path)?),
        None => match std::env::var("STYLET_TOKEN") {
            Ok(text) => ("STYLET_TOKEN".to_owned(), text),
            Err(_) => return Err(Failure::input("no token: pass --token-file F or set STYLET_TOKEN")),
        },
    };
    let text = text.trim();
    let valid = !text.is_empty() && text.chars().all(|c| c.is_ascii_graphic());
    match HeaderValue::from_str(&format!("Bearer {text}")) {
        Ok(mut value) if valid => {
            value.set_sensitive(true);
            Ok(value)
        }
        _ => Err(Failure::input(format_args!("{place}: the token must be one word of printable ASCII"))),
    }
}
