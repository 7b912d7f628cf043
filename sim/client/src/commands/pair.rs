//! `stylet pair`: registers this machine with a school as a training station.

use std::io::{self, BufRead, IsTerminal, Write};

use serde::Serialize;
use serde_json::json;
use ureq::http::Uri;

use crate::exit::{Failure, Outcome};
use crate::service::{self, ask_service};
use crate::station::{self, NewKey, Pairing, StationKey};
use crate::{machine, output};

/// Join this machine to a school as a training station
///
/// The school's administrator creates a code on the page Administration; it is valid for one use
/// within ten minutes. The service gives this station a token of its own, which is stored for this
/// user only and can be revoked on the same page. This station creates a key pair, sends the public
/// key to the service, and signs all recordings made here from now on. An existing pairing of this
/// user is replaced, including its key.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  stylet pair --server https://training.example.org --name 'Skills lab 2'")]
pub struct PairArgs {
    /// Address of the service, http or https
    #[arg(long, value_name = "URL", value_parser = service::parse_server_address)]
    server: Uri,
    /// The pairing code; prompted for on a terminal if omitted
    #[arg(long, value_name = "CODE")]
    code: Option<String>,
    /// Name of the station at its school [default: the name of this machine]
    #[arg(long, value_name = "NAME")]
    name: Option<String>,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

/// Output of a pairing, without the token.
#[derive(Serialize)]
struct Joined<'a> {
    server: &'a str,
    school: &'a str,
    name: &'a str,
    file: String,
}

/// Runs the command.
pub fn run(args: &PairArgs) -> Outcome {
    if service::is_in_the_clear(&args.server) {
        let warning = "http is not encrypted: other devices on the network can read the station's token";
        output::print_warning(format_args!("{}: {warning}", args.server));
    }
    // Before the code is used up: check that the token can be stored.
    let (file, _) = (station::file()?, StationKey::file()?);
    let code = match &args.code {
        Some(code) => code.clone(),
        None => ask()?,
    };
    let name = args.name.clone().unwrap_or_else(machine::machine_name);
    let (pairing, key) = join(&args.server, &code, &name)?;
    key.save()?;
    pairing.save()?;
    let Pairing { server, school, name, .. } = &pairing;
    match args.json {
        true => output::print_json(&Joined { server, school, name, file: file.display().to_string() }),
        false => output::print_line(format_args!("this station is now \"{name}\" of {school} at {server}")),
    }
}

fn ask() -> Result<String, Failure> {
    let mut input = io::stdin().lock();
    if !io::stdin().is_terminal() {
        return Err(Failure::input("no code: pass --code CODE, or run this command in a terminal"));
    }
    let mut line = String::new();
    let mut prompt = io::stderr();
    let asked =
        write!(prompt, "Pairing code: ").and_then(|()| prompt.flush()).and_then(|()| input.read_line(&mut line));
    asked.map_err(|error| Failure::work(format_args!("the code cannot be read: {error}")))?;
    Ok(line.trim().to_owned())
}

fn join(server: &Uri, code: &str, name: &str) -> Result<(Pairing, StationKey), Failure> {
    let key = NewKey::random();
    let server = server.to_string().trim_end_matches('/').to_owned();
    let address = format!("{server}/api/v1/stations/pair");
    let body = json!({ "code": code, "name": name, "public_key": key.public() }).to_string();
    let asked = service::http_agent().post(&address).content_type("application/json").send(body);
    let reply = ask_service(&address, asked).map_err(|trouble| Failure::work(trouble.detail))?;
    let said = reply.json().unwrap_or_default();
    let member = |name: &str| said.get(name).and_then(|value| value.as_str()).map(str::to_owned);
    let station = member("station_id").and_then(|id| id.parse().ok());
    match (reply.status, station.zip(member("token")), member("school"), member("name")) {
        (201, Some((station, token)), Some(school), Some(name)) if service::bearer_header(&token).is_some() => {
            Ok((Pairing { server, school, name, token }, key.for_station(station)))
        }
        _ => Err(Failure::work(format_args!("{address}: not paired: {}", reply.words()))),
    }
}
