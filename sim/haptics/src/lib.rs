//! Haptic devices behind one trait, the servo loop that reads and drives them, and the safety chain
//! between the force law and the motors.
//!
//! [`servo::start`] takes a force law and a device and returns the handles for the recorder and the
//! display. However the servo ends, the last force sent to the device is zero.
//!
//! ```
//! use std::sync::Arc;
//!
//! use haptics::devices::hand::{Aim, VirtualHand};
//! use haptics::mapping::{Home, Mapping, Pointing};
//! use haptics::servo::{self, Driven, Setup};
//! use law::puncture::PunctureParams;
//! use nalgebra::{Point3, Vector3};
//!
//! # use law::axial::{AxialSpec, ForceLaw, Layer, LayerOptions};
//! # use law::puncture::PunctureSpec;
//! # let skin = Layer { name: "skin".to_owned(), thickness_m: 0.02, stiffness_n_per_m: 331.0, damping_n_s_per_m2: 300.0,
//! #     tip_rupture_n: 1.0, rim_rupture_n: 1.3, friction_n_per_m: 100.0, cutting_n: 0.3,
//! #     options: LayerOptions::default() };
//! # let axial = AxialSpec {
//! #     law: ForceLaw::Version5,
//! #     layers: vec![skin],
//! #     tip_to_rim_m: 0.002,
//! #     presliding_stiffness_n_per_m: 2000.0,
//! #     speed_window_s: 0.0075,
//! #     damping_time_s: 0.01,
//! #     rate: None,
//! #     breakaway: None,
//! # };
//! # let spec = PunctureSpec { axial, lateral_stiffness_n_per_m2: 1e4, needle_length_m: 0.15, hub_stiffness_n_per_m: None, needle_bending_n_m2: None,
//! #     skin: law::Skin::Flat, structures: Vec::new() };
//! let params = Arc::new(PunctureParams::new(spec)?);
//! let rate_hz = 1000.0;
//! // A hand that the mouse moves. Open a real device here instead.
//! let (hand, mut aim) = VirtualHand::new("mouse", &VirtualHand::braced(), rate_hz);
//! let driven = Driven::ByTimer(Box::new(hand));
//! // At the first reading of the handle, the needle is 20 mm above the planned entry.
//! let home = Home::above(Point3::origin(), -Vector3::z_axis(), 0.02);
//! let mapping = Mapping::at_home(home, Pointing::Planned);
//! let setup = Setup::new(params, mapping, driven.info(), 0.015, rate_hz);
//! println!("{}", setup.scaling);
//!
//! let mut started = servo::start(setup, driven)?;
//! // The window moves the set-point...
//! aim.write(Aim { position_m: Vector3::new(0.0, -0.03, 0.0), ..Aim::default() });
//! # std::thread::sleep(std::time::Duration::from_millis(50));
//! // ...the display reads the latest tick...
//! if let Some(latest) = started.latest.read() {
//!     println!("{:.2} N at {:.1} mm", latest.output.force_n.norm(), latest.output.x_m * 1e3);
//! }
//! // ...and the recorder's thread takes every tick.
//! while let Some(record) = started.records.pop() {
//!     assert!(record.t_s >= 0.0);
//! }
//! if let Some(report) = started.running.stop() {
//!     println!("{report}");
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod clamp;
mod clock;
pub mod device;
pub mod devices;
pub mod inverse3;
pub mod mapping;
pub mod openhaptics;
pub mod safety;
pub mod scaling;
pub mod servo;
pub mod test_wall;
