//! The wall for testing a device: a spring within the limits of the device that returns no more energy than it took.
//!
//! Fails if the force is not that of the spring, exceeds the limit of the wall or of the device, pulls, or drives a handle that
//! rebounds; the last would be felt as a wall that rattles.

use haptics::device::DeviceInfo;
use haptics::mapping::Mapping;
use haptics::safety::passivity::FELT_N;
use haptics::test_wall::TestWall;
use nalgebra::Vector3;

use crate::free_handle::{Bench, Gain, HANDLE, Release};
use crate::support::{PERIOD_S, RATE_HZ, Rig, device, reading, touch};

fn devices() -> [DeviceInfo; 3] {
    [touch(), device("Omni", 3.3, 0.88, 700.0), device("Inverse3", 10.0, 10.0, 1000.0)]
}

fn bench(info: &DeviceInfo) -> (TestWall, Bench) {
    let wall = TestWall::new(info);
    (wall, Bench::of(wall.setup(Mapping::in_patient_frame(), info, RATE_HZ)))
}

#[test]
fn wall_is_a_spring_up_to_its_greatest_force() {
    for info in devices() {
        let (wall, mut bench) = bench(&info);
        assert!(wall.max_force_n < info.max_force_n && wall.stiffness_n_per_m <= info.max_stiffness_n_per_m);
        bench.wait();
        for depth_m in [0.5e-3, 2e-3, 4e-3, 1e-3, 15e-3, 29e-3, 3e-3, -1e-3] {
            bench.go_on(depth_m);
            let sent_n = -bench.sent_n.last().expect("a force");
            let wanted_n = wall.force_n(depth_m);
            assert!((sent_n - wanted_n).abs() < 1e-6, "{sent_n} N of {wanted_n} N at {depth_m} m on {}", info.name);
        }
        let greatest_n = bench.sent_n.iter().fold(0.0_f64, |most_n, n| most_n.max(n.abs()));
        assert!((greatest_n - wall.max_force_n).abs() < 1e-6, "{greatest_n} N on {}", info.name);
        // The damping of the energy observer opposes the way out, imperceptibly.
        let pull_n = bench.sent_n.iter().fold(0.0_f64, |most_n, n| most_n.max(*n));
        assert!(pull_n < FELT_N, "the wall pulls with {pull_n} N on {}", info.name);
    }
}

#[test]
fn wall_on_a_device_without_motors_gives_no_force() {
    let wall = TestWall::new(&device("pen", 0.0, 0.0, 0.0));
    assert!(wall.max_force_n.abs() < 1e-12 && wall.force_n(0.01).abs() < 1e-12);
    let info = device("pen", 0.0, 0.0, 0.0);
    let mut rig = Rig::of(wall.setup(Mapping::in_patient_frame(), &info, RATE_HZ));
    for tick in 0..3000 {
        let depth_m = 5e-6 * f64::from(tick);
        let force_n = rig.tick(Ok(reading(f64::from(tick) * PERIOD_S, Vector3::new(0.0, 0.0, -depth_m))));
        assert!(force_n.expect("it goes on").norm() < 1e-12);
    }
}

#[test]
fn released_handle_gains_no_energy_from_the_wall() {
    for info in devices() {
        for (delay, allowed, kept) in [(0, 0.02, 0.0), (1, 0.30, 0.05)] {
            for speed_m_per_s in [0.0, 0.1] {
                let (wall, mut bench) = bench(&info);
                let x_m = 0.8 * wall.max_force_n / wall.stiffness_n_per_m;
                bench.go(x_m);
                let release = Release { x_m, push_n: 0.0, speed_m_per_s, delay, held: HANDLE };
                let Gain { at_once, later } = bench.let_go(&release);
                let case = format!("{} with {delay} ms more, thrown at {speed_m_per_s} m/s", info.name);
                assert!(at_once < allowed && later <= kept, "{case} gains {at_once}, keeps {later}");
            }
        }
    }
}
