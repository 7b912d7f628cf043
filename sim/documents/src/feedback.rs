//! Feedback during an attempt: one table of the channels that each mode opens or closes, so that no
//! output is missed.

use phrase::sentence;
use serde::Deserialize;

/// Feedback given to the trainee during an attempt. The modes allow a school to repeat the
/// comparison of force, picture and overlay.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Feedback {
    /// Force in the hand, and the body from outside.
    Force,
    /// The inside of the body in the picture; no force.
    Picture,
    /// Depth, force and layer as numbers and plots, and the body from outside; no force.
    Overlay,
    /// Force in the hand, the body from outside, and X-rays.
    Fluoroscopy,
    /// Everything.
    #[default]
    Both,
}

/// A channel that reveals the needle's position to the trainee. Other information (remaining time,
/// entry point, confirmation of the position, device faults) is shown in every mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    /// Force feedback of the device.
    Force,
    /// The picture shows the inside of the body: layers, tents, structures, and contact with a
    /// structure.
    Inside,
    /// The target and the planned path below the skin are marked.
    Target,
    /// Depth, force, angle and layer as numbers and plots.
    Readings,
    /// Pops and hits are captioned as they happen.
    Captions,
    /// Pops are audible.
    Sound,
    /// Coaching messages of the exercise when a quantity exceeds its limit.
    Coaching,
    /// X-ray pictures, if the exercise has a C-arm.
    Fluoroscopy,
}

impl Channel {
    /// Every channel.
    pub const ALL: [Self; 8] = [
        Self::Force,
        Self::Inside,
        Self::Target,
        Self::Readings,
        Self::Captions,
        Self::Sound,
        Self::Coaching,
        Self::Fluoroscopy,
    ];
}

impl Feedback {
    /// Every mode.
    pub const ALL: [Self; 5] = [Self::Force, Self::Picture, Self::Overlay, Self::Fluoroscopy, Self::Both];

    /// Returns whether a channel is open:
    ///
    /// | | force | picture | overlay | fluoroscopy | both |
    /// |---|---|---|---|---|---|
    /// | force | yes | – | – | yes | yes |
    /// | inside | – | yes | – | – | yes |
    /// | target | – | yes | yes | – | yes |
    /// | readings | – | – | yes | – | yes |
    /// | captions | – | – | yes | – | yes |
    /// | sound | – | – | yes | – | yes |
    /// | coaching | – | – | yes | yes | yes |
    /// | fluoroscopy | – | yes | – | yes | yes |
    #[must_use]
    pub const fn gives(self, channel: Channel) -> bool {
        let [force, picture, overlay, fluoroscopy, both] = match channel {
            Channel::Force => [true, false, false, true, true],
            Channel::Inside => [false, true, false, false, true],
            Channel::Target => [false, true, true, false, true],
            Channel::Readings | Channel::Captions | Channel::Sound => [false, false, true, false, true],
            Channel::Coaching => [false, false, true, true, true],
            Channel::Fluoroscopy => [false, true, false, true, true],
        };
        match self {
            Self::Force => force,
            Self::Picture => picture,
            Self::Overlay => overlay,
            Self::Fluoroscopy => fluoroscopy,
            Self::Both => both,
        }
    }

    /// Describes the mode to the trainee before the attempt.
    #[must_use]
    pub const fn in_words(self) -> &'static str {
        match self {
            Self::Force => sentence!(
                "force in your hand; the picture shows only the outside of the body, without messages or sounds"
            ),
            Self::Picture => {
                sentence!("the picture shows the inside of the body and the target; no force in your hand")
            }
            Self::Overlay => {
                sentence!("depth, force, layer and target are shown and pops are announced; no force in your hand")
            }
            Self::Fluoroscopy => {
                sentence!(
                    "force in your hand and X-rays; the picture shows only the outside of the body, without the target"
                )
            }
            Self::Both => sentence!("force in your hand, the inside of the body, depth, force and layer"),
        }
    }
}

#[cfg(test)]
mod tests {
    //! A study that compares feedback modes is invalid if a closed channel still leaks information.
    //! The window's tests assert that each channel is checked with `gives`.

    use super::*;

    fn open(feedback: Feedback) -> Vec<Channel> {
        Channel::ALL.into_iter().filter(|channel| feedback.gives(*channel)).collect()
    }

    #[test]
    fn force_alone_is_force_alone_and_both_is_everything() {
        assert_eq!(open(Feedback::Force), [Channel::Force]);
        assert_eq!(open(Feedback::Picture), [Channel::Inside, Channel::Target, Channel::Fluoroscopy]);
        assert_eq!(open(Feedback::Fluoroscopy), [Channel::Force, Channel::Coaching, Channel::Fluoroscopy]);
        assert!(
            !open(Feedback::Overlay).contains(&Channel::Force) && !open(Feedback::Overlay).contains(&Channel::Inside)
        );
        assert_eq!(open(Feedback::Both), Channel::ALL);
        for channel in Channel::ALL {
            assert!(Feedback::ALL.iter().any(|mode| !mode.gives(channel)), "{channel:?} can be withheld");
        }
    }
}
