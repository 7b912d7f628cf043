//! What the service says.

use serde_json::{Value, json};

/// The arm and its grip.
#[derive(Clone, Debug)]
pub struct State {
    /// Identifier of the arm.
    pub device_id: &'static str,
    /// The arm is calibrated.
    pub calibrated: bool,
    /// The arm has power.
    pub power_supply: bool,
    /// Way of the handle from one frame to the next, in m along the service's axes.
    pub step_m: [f64; 3],
    /// Where the handle is held instead, in m from where it starts.
    pub held_m: Option<[f64; 3]>,
    /// Step of its encoders, in m; 0 for one that has none.
    pub encoder_m: f64,
    /// The grip.
    pub grip: Grip,
    /// Orientation of the grip: x, y, z, w.
    pub orientation: [f64; 4],
    /// The grip's first and second button.
    pub buttons: [bool; 2],
    /// The force that the arm is given, in N along the service's axes.
    pub force_n: [f64; 3],
}

/// Which grip is connected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grip {
    /// None.
    None,
    /// One with a cable and one button.
    Wired,
    /// One without a cable.
    Wireless,
}

impl Default for State {
    fn default() -> Self {
        Self {
            device_id: "04C3",
            calibrated: true,
            power_supply: true,
            step_m: [1e-4, 0.0, 0.0],
            held_m: None,
            encoder_m: 0.0,
            grip: Grip::Wireless,
            orientation: [0.0, 0.0, 0.0, 1.0],
            buttons: [false; 2],
            force_n: [0.0; 3],
        }
    }
}

/// The first frame, with the configuration.
#[must_use]
pub fn first(state: &State) -> String {
    let mut frame = frame(state, 0);
    frame["inverse3"][0]["config"] =
        json!({ "type": "inverse3", "handedness": "right", "device_info": { "id": 1219 } });
    frame.to_string()
}

/// A later frame: the handle has gone so many steps from (0, −150, 160) mm in the service's axes.
#[must_use]
pub fn state(state: &State, step: usize) -> String {
    frame(state, step).to_string()
}

fn frame(state: &State, step: usize) -> Value {
    let [force_x, force_y, force_z] = state.force_n;
    let way_m = state.held_m.unwrap_or_else(|| state.step_m.map(|step_m| step_m * step as f64));
    let [x_m, y_m, z_m] =
        way_m.map(|m| if state.encoder_m > 0.0 { (m / state.encoder_m).floor() * state.encoder_m } else { m });
    let mut frame = json!({
        "session_id": 7,
        "inverse3": [{
            "device_id": state.device_id,
            "state": {
                "cursor_position": { "x": x_m, "y": y_m - 0.150, "z": z_m + 0.160 },
                "cursor_velocity": { "x": 0.1, "y": 0.0, "z": 0.0 },
                "current_cursor_force": { "x": force_x, "y": force_y, "z": force_z },
                "body_orientation": { "x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0 },
            },
            "status": {
                "calibrated": state.calibrated, "ready": state.calibrated && state.power_supply, "in_use": false,
                "power_supply": state.power_supply, "started": true,
            },
        }],
    });
    let [x, y, z, w] = state.orientation;
    let orientation = json!({ "x": x, "y": y, "z": z, "w": w });
    let [a, b] = state.buttons;
    match state.grip {
        Grip::None => {}
        Grip::Wired => {
            let grip = json!({ "orientation": orientation, "hall": 0, "button": a });
            frame["verse_grip"] = json!([{ "device_id": "61576", "state": grip }]);
        }
        Grip::Wireless => {
            let buttons = json!({ "a": a, "b": b, "c": false });
            let grip = json!({ "orientation": orientation, "buttons": buttons, "battery_level": 0.8, "hall": 0 });
            frame["wireless_verse_grip"] = json!([{ "device_id": "A1", "state": grip }]);
        }
    }
    frame
}
