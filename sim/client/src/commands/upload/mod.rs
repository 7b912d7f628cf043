//! `stylet upload`: sends recordings to the service through the outbox.

use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::builder::RangedU64ValueParser;
use ureq::http::Uri;

use crate::exit::{Failure, Outcome};
use crate::outbox::{Access, Delivery, Outbox, Patience, Post};
use crate::service::{self, Service};
use crate::station::Pairing;
use crate::{output, sources};

/// Send recordings to a service
///
/// Each recording is kept in the outbox until the service confirms that it is stored. It is sent in
/// pieces: an interrupted upload resumes where it stopped. Network errors and a busy or failing
/// service are retried with a wait that doubles each time; recordings that could not be delivered
/// stay in the outbox with the reason (stylet outbox). The token is the station's own (stylet
/// pair), or is read from --token-file or the environment variable STYLET_TOKEN, never from the
/// command line, which other users can see.
#[derive(clap::Args)]
#[command(
    after_help = "Example:\n  stylet upload *.mcap --server https://training.example.org --token-file ~/.stylet-token"
)]
pub struct UploadArgs {
    /// The recordings
    #[arg(value_name = "REC.mcap", required = true)]
    recordings: Vec<PathBuf>,
    /// Address of the service, http or https
    #[arg(long, value_name = "URL", value_parser = service::parse_server_address)]
    server: Uri,
    /// File that contains the bearer token
    #[arg(long, value_name = "F")]
    token_file: Option<PathBuf>,
    /// Folder of the outbox [default: the user's own]
    #[arg(long, value_name = "DIR", env = "STYLET_OUTBOX")]
    outbox: Option<PathBuf>,
    #[command(flatten)]
    patience: PatienceArgs,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

/// Number of retries, and the wait between them.
#[derive(clap::Args)]
pub struct PatienceArgs {
    /// Number of retries after a network error or a service failure without any progress since the
    /// last attempt
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = RangedU64ValueParser::<u32>::new().range(0..=20))]
    retries: u32,
    /// Wait before the first retry, in ms; doubled each time, up to a minute
    #[arg(long, value_name = "MS", default_value_t = 500, value_parser = RangedU64ValueParser::<u64>::new().range(1..=60_000))]
    retry_wait_ms: u64,
}

impl From<&PatienceArgs> for Patience {
    fn from(args: &PatienceArgs) -> Self {
        Self { retries: args.retries, first_wait: Duration::from_millis(args.retry_wait_ms) }
    }
}

/// Runs the command.
pub fn run(args: &UploadArgs) -> Outcome {
    for recording in &args.recordings {
        sources::open(recording)?;
    }
    let service = named_service(&args.server, args.token_file.as_deref())?;
    let outbox = Outbox::open(args.outbox.as_deref())?;
    let kept: Result<Vec<_>, _> =
        args.recordings.iter().map(|recording| outbox.keep(recording, Some(&service.address))).collect();
    let access = Access::new(Some(service), None);
    let post = Post::open(&outbox, &access, Patience::from(&args.patience))?;
    let deliveries: Result<Vec<Delivery>, Failure> = kept?.iter_mut().map(|entry| post.send(entry)).collect();
    report(&deliveries?, &outbox, args.json)
}

/// Reports deliveries; returns [`Failure::Found`] if one failed.
pub fn report(deliveries: &[Delivery], outbox: &Outbox, json: bool) -> Outcome {
    for delivery in deliveries {
        let (name, detail) = (&delivery.recording, &delivery.detail);
        match (delivery.delivered, json) {
            (true, false) => output::print_line(format_args!("{name}: delivered: {detail}"))?,
            (true, true) => {}
            (false, _) if delivery.is_removed() => {
                output::print_error(format_args!("{name}: not delivered: {detail}"));
            }
            (false, _) => {
                let folder = outbox.folder().display();
                output::print_error(format_args!("{name}: not delivered: {detail}; kept in the outbox {folder}"));
            }
        }
    }
    if json {
        output::print_json(&deliveries)?;
    }
    if deliveries.iter().all(|delivery| delivery.delivered) { Ok(()) } else { Err(Failure::Found) }
}

/// The service given on the command line, with its token.
pub fn named_service(server: &Uri, token_file: Option<&Path>) -> Result<Service, Failure> {
    if service::is_in_the_clear(server) {
        output::print_warning(format_args!(
            "{server}: http is not encrypted: other devices on the network can read the token"
        ));
    }
    let address = server.to_string();
    let (place, token) = token(address.trim_end_matches('/'), token_file)?;
    let bearer = service::bearer_header(token.trim()).ok_or_else(|| {
        // The token is never printed.
        Failure::input(format_args!("{place}: the token must be one word of printable ASCII"))
    })?;
    Ok(Service::new(&address, bearer))
}

/// The token for a service, and its source.
fn token(address: &str, file: Option<&Path>) -> Result<(String, String), Failure> {
    if let Some(path) = file {
        return Ok((path.display().to_string(), sources::read_text(path)?));
    }
    if let Ok(token) = std::env::var("STYLET_TOKEN") {
        return Ok(("STYLET_TOKEN".to_owned(), token));
    }
    match Pairing::load()? {
        Some(pairing) if pairing.server == address => Ok(("the station's pairing".to_owned(), pairing.token)),
        _ => Err(Failure::input(format_args!(
            "no token for {address}: pair this station (stylet pair), pass --token-file F or set STYLET_TOKEN"
        ))),
    }
}
