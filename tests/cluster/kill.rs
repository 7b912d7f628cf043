//! `cluster kill`: services are killed in the middle of everything, one after the other.

use std::sync::Arc;
use std::thread;
use std::time::Duration;

use clap::Args;
use tests::dice::Dice;
use tests::endings::say;

use crate::check;
use crate::client::Proxy;
use crate::fleet::{Replica, ports, start_four};
use crate::ledger::Ledger;
use crate::load::Load;
use crate::school::{School, SchoolArgs};

/// Longest pause between a service that is at work again and the next kill, in ms.
const LONGEST_PEACE_MS: u64 = 2500;

/// How to kill
#[derive(Debug, Args)]
pub struct KillArgs {
    #[command(flatten)]
    school: SchoolArgs,
    /// How often a service is killed
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..))]
    kills: u32,
    /// Trainees who upload at once; half as many teach
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u16).range(1..=100))]
    trainees: u16,
}

/// Kills as often as asked; whether all is well in the end.
pub fn run(args: &KillArgs) -> anyhow::Result<bool> {
    let school = Arc::new(School::found(&args.school)?);
    let mut fleet = start_four(&school)?;
    let (proxy, ledger) = (Arc::new(Proxy::before(ports(&fleet))), Arc::new(Ledger::default()));
    let mut load = Load::begin(&school, &proxy, &ledger, usize::from(args.trainees))?;
    say(&format!("{} kills, seed {}, in {}", args.kills, args.school.seed, school.folder.display()));
    let mut dice = Dice::new(args.school.seed);
    let mut killed = [0; 4];
    for number in 1..=args.kills {
        thread::sleep(Duration::from_millis(dice.below(LONGEST_PEACE_MS)));
        load.look_after()?;
        let victim = dice.below(4) as usize;
        fleet[victim].kill()?;
        killed[victim] += 1;
        fleet[victim].start_again()?;
        fleet.iter_mut().try_for_each(Replica::look_after)?;
        if number % 10 == 0 {
            say(&format!("{number} killed"));
        }
    }
    load.end()?;
    say("the harm is over; what waits is scored and sent");
    // What two deaths of services happened to hit is tried again when somebody asks for it.
    let set_aside = school.count(
        "SELECT (SELECT count(*) FROM jobs WHERE deaths > 1) + (SELECT count(*) FROM uploads WHERE deaths > 1)",
    )?;
    if set_aside > 0 {
        school.web_admin(&["retry"])?;
    }
    check::await_queues(&school)?;
    let most = check::tell_requests(&ledger.tallies());
    let mut verdict = check::pass(&school, &proxy, &ledger)?;
    verdict.count("kills of who serves", killed[0] + killed[1]);
    verdict.count("kills of who works", killed[2] + killed[3]);
    verdict.count("set aside, hit twice, tried again when asked", set_aside as usize);
    verdict.count("most retries of a request", most as usize);
    say(&verdict.table());
    fleet.iter_mut().try_for_each(Replica::leave)?;
    Ok(verdict.is_good())
}
