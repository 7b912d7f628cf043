//! A device pressed against a virtual wall: the running servo and its measurements.

use haptics::device::DeviceInfo;
use haptics::mapping::Home;
use haptics::safety::flags;
use haptics::servo::{self, Record, Records, Running, flags as servo_flags};
use haptics::test_wall::TestWall;
use nalgebra::{Point3, Vector3};
use phrase::{Phrase, phrase};

use super::open::{self, DeviceChoice, Steered};
use crate::exit::Failure;

/// Distance of the needle from the wall at the start, in m.
const APPROACH_M: f64 = 0.010;
/// Time for which the wall must be pressed for a verdict, in s, and the fraction of its greatest
/// force that counts as pressed.
const PRESSED_S: f64 = 0.5;
const PRESSED: f64 = 0.3;
/// Fraction of the wall's force that the device must be sent on average.
const ENOUGH: f64 = 0.95;
/// Fraction of the ticks with the same trouble that counts as that trouble.
const OFTEN: f64 = 0.05;
/// Number of points kept of the measured curve, and the least distance between two, in m.
const MOST_POINTS: usize = 400;
const APART_M: f64 = 2e-5;

/// Returns the start of the needle: above the wall, pointing at it.
fn home() -> Home {
    Home::above(Point3::origin(), -Vector3::z_axis(), APPROACH_M)
}

/// A test in progress. Dropping it stops the servo with zero force on the device.
pub struct WallTest {
    /// The device.
    pub info: DeviceInfo,
    /// The wall.
    pub wall: TestWall,
    /// Source of the device's motion.
    pub steered: Steered,
    /// Measurements so far.
    pub measured: WallMeasurement,
    running: Running,
    records: Records,
    rate_hz: f64,
}

impl WallTest {
    /// Opens a device and starts the servo.
    ///
    /// # Errors
    /// If the device is missing or cannot be opened, or the servo cannot be started.
    pub fn start(choice: &DeviceChoice, desk: &open::Desk<'_>, rate_hz: f64) -> Result<Self, Failure> {
        let opened = open::open_at(choice, desk, &home(), rate_hz)?;
        let info = opened.driven.info().clone();
        let wall = TestWall::new(&info);
        let setup = wall.setup(opened.mapping.pointing_as_planned(), &info, rate_hz);
        let started =
            servo::start(setup, opened.driven).map_err(|error| Failure::work(format_args!("servo: {error}")))?;
        let (running, records) = (started.running, started.records);
        Ok(Self {
            info,
            wall,
            steered: opened.steered,
            measured: WallMeasurement::default(),
            running,
            records,
            rate_hz,
        })
    }

    /// Takes the ticks since the last call.
    pub fn take_ticks(&mut self) {
        while let Some(record) = self.records.pop() {
            self.measured.add(&record, &self.wall);
        }
    }

    /// Returns the servo.
    pub fn servo(&self) -> &Running {
        &self.running
    }

    /// Returns the verdict so far.
    pub fn verdict(&self) -> WallVerdict {
        self.measured.judge(self.rate_hz, self.info.max_force_n > 0.0)
    }
}

/// Measurements at a wall.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WallMeasurement {
    /// Depth of the tip in the wall at the last tick, in m; negative above it.
    pub depth_m: f64,
    /// Force of the wall at the last tick, in N.
    pub wall_n: f64,
    /// Force sent to the device at the last tick, in N.
    pub sent_n: f64,
    /// Flags of the last tick.
    pub flags: u32,
    /// Depth in mm and force sent in N, the latest last.
    pub curve: Vec<[f64; 2]>,
    /// Ticks that count: pressed, and the force fully let in.
    pressed: u32,
    /// Sums of both forces over them, in N.
    wall_sum_n: f64,
    sent_sum_n: f64,
    /// Number of pressed ticks with a rejected force, and with another force than the sent one.
    refused: u32,
    disagreed: u32,
}

/// Result of a test.
#[derive(Clone, Debug, PartialEq)]
pub enum WallVerdict {
    /// Not pressed for long enough.
    Press,
    /// The device was sent the force of the wall.
    Good(Phrase),
    /// It was not, or it did not give it.
    Bad(Phrase),
}

impl WallMeasurement {
    /// Adds a tick.
    fn add(&mut self, record: &Record, wall: &TestWall) {
        let norm_n = |force_n: [f32; 3]| Vector3::from(force_n).cast::<f64>().norm();
        self.depth_m = -record.position_m[2];
        self.wall_n = wall.force_n(self.depth_m);
        self.sent_n = norm_n(record.device_n);
        self.flags = record.flags;
        let has = |flag: u32| record.flags & flag != 0;
        if self.wall_n < PRESSED * wall.max_force_n || self.wall_n <= 0.0 {
            return;
        }
        self.refused += u32::from(has(servo_flags::REFUSED));
        if has(flags::GATED | flags::RISE_LIMITED) {
            return;
        }
        self.pressed += 1;
        self.disagreed += u32::from(has(servo_flags::DISAGREES));
        self.wall_sum_n += self.wall_n;
        self.sent_sum_n += self.sent_n;
        self.keep_point([self.depth_m * 1e3, self.sent_n]);
    }

    fn keep_point(&mut self, point: [f64; 2]) {
        if self.curve.last().is_some_and(|last| (last[0] - point[0]).abs() < APART_M * 1e3) {
            return;
        }
        if self.curve.len() >= MOST_POINTS {
            self.curve.remove(0);
        }
        self.curve.push(point);
    }

    /// Judges the measurements at a tick rate in Hz.
    fn judge(&self, rate_hz: f64, has_motors: bool) -> WallVerdict {
        let often = |ticks: u32| f64::from(ticks) > OFTEN * PRESSED_S * rate_hz;
        if !has_motors {
            return WallVerdict::Bad(phrase!("This device has no force feedback"));
        }
        if often(self.refused) {
            return WallVerdict::Bad(phrase!("The device rejects the force: you feel nothing"));
        }
        if f64::from(self.pressed) < PRESSED_S * rate_hz {
            return WallVerdict::Press;
        }
        if f64::from(self.disagreed) > OFTEN * f64::from(self.pressed) {
            return WallVerdict::Bad(phrase!("The device reports a different force from the one sent"));
        }
        let share = self.sent_sum_n / self.wall_sum_n.max(f64::MIN_POSITIVE);
        let percent = Phrase::number(share.min(1.0) * 100.0, 0);
        if share >= ENOUGH {
            WallVerdict::Good(phrase!("The device is sent {percent} % of the wall’s force", percent = percent))
        } else {
            WallVerdict::Bad(phrase!("The device is sent only {percent} % of the wall’s force", percent = percent))
        }
    }
}

#[cfg(test)]
mod tests {
    //! Fails if a device that withholds the force passes, or one that gives it fails.

    use haptics::devices::hand::Aim;

    use super::*;
    use crate::devices::DeviceArgs;
    use crate::settings::Settings;

    const RATE_HZ: f64 = 1000.0;
    const WALL: TestWall = TestWall { stiffness_n_per_m: 500.0, max_force_n: 3.0 };

    /// Returns the verdict on a handle that rests 4 mm in the wall, which gives 2 N there, on a
    /// device that is sent a fraction of it, with flags.
    fn verdict(share: f32, flags: u32, ticks: u32) -> WallVerdict {
        let mut measured = WallMeasurement::default();
        for _ in 0..ticks {
            let device_n = [0.0, 0.0, 2.0 * share];
            measured.add(&Record { position_m: [0.0, 0.0, -0.004], device_n, flags, ..Record::default() }, &WALL);
        }
        assert!((measured.wall_n - 2.0).abs() < 1e-12 && (measured.depth_m - 0.004).abs() < 1e-12);
        measured.judge(RATE_HZ, true)
    }

    #[test]
    fn verdict_needs_half_a_second_and_nearly_all_of_the_force() {
        assert_eq!(verdict(1.0, 0, 499), WallVerdict::Press);
        assert!(matches!(verdict(1.0, 0, 500), WallVerdict::Good(_)));
        assert!(matches!(verdict(0.97, 0, 800), WallVerdict::Good(_)));
        assert!(matches!(verdict(0.6, flags::THERMAL, 800), WallVerdict::Bad(_)));
        assert_eq!(verdict(0.1, flags::GATED, 5000), WallVerdict::Press, "the force is still coming in");
        for fault in [servo_flags::REFUSED, servo_flags::DISAGREES] {
            assert!(matches!(verdict(1.0, fault, 800), WallVerdict::Bad(_)));
        }
        assert!(matches!(WallMeasurement::default().judge(RATE_HZ, false), WallVerdict::Bad(_)));
    }

    #[test]
    fn a_stand_in_pressed_at_the_wall_feels_its_spring() {
        let (args, settings) = (DeviceArgs::default(), Settings::default());
        let desk = open::Desk { args: &args, settings: &settings };
        let mut test = WallTest::start(&DeviceChoice::Mouse, &desk, RATE_HZ).expect("a mouse is always there");
        let Steered::Window(aim) = &mut test.steered else { panic!("the window steers it") };
        // From 10 mm above the wall to a set-point 4 mm in it.
        aim.write(Aim { position_m: Vector3::new(0.0, -0.014, 0.0), ..Aim::default() });
        while !matches!(test.verdict(), WallVerdict::Good(_)) {
            assert!(test.servo().ended().is_none() && !matches!(test.verdict(), WallVerdict::Bad(_)));
            std::thread::sleep(std::time::Duration::from_millis(5));
            test.take_ticks();
        }
        let WallMeasurement { depth_m, sent_n, ref curve, .. } = test.measured;
        // The hand's spring of 1500 N/m and the wall's share the 4 mm.
        let wanted_m = 0.004 * 1500.0 / (1500.0 + test.wall.stiffness_n_per_m);
        assert!((depth_m - wanted_m).abs() < 5e-5, "{depth_m} m of {wanted_m} m");
        assert!((sent_n - test.wall.force_n(depth_m)).abs() < 0.02, "{sent_n} N");
        assert!(!curve.is_empty() && curve.len() <= MOST_POINTS);
    }
}
