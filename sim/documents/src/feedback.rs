//! What a trainee is given during an attempt, and what is withheld: one table, so that no door is forgotten.

use phrase::sentence;
use serde::Deserialize;

/// What the trainee is given during an attempt, so that a school can repeat the comparison of force, picture and overlay.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Feedback {
    /// Force in the hand, and the body from outside.
    Force,
    /// The inside of the body in the picture; no force.
    Picture,
    /// Depth, force and layer as numbers and plots, and the body from outside; no force.
    Overlay,
    /// Everything.
    #[default]
    Both,
}

/// A way by which an attempt tells a trainee where the needle is. What is not among these (the time left, where to enter, that the position is
/// confirmed, what is wrong with the device) is told to everybody.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    /// The device pushes.
    Force,
    /// The picture shows the inside of the body: layers, tents, structures, and which of them is touched.
    Inside,
    /// The target is marked, and the planned way to it below the skin.
    Target,
    /// Depth, force, angle and layer as numbers and plots.
    Readings,
    /// Pops and hits are named as they happen.
    Captions,
    /// Pops are heard.
    Sound,
    /// What the exercise has to say to a quantity that goes too far.
    Coaching,
}

impl Channel {
    /// All of them.
    pub const ALL: [Self; 7] =
        [Self::Force, Self::Inside, Self::Target, Self::Readings, Self::Captions, Self::Sound, Self::Coaching];
}

impl Feedback {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Force, Self::Picture, Self::Overlay, Self::Both];

    /// Whether a channel is open:
    ///
    /// | | force | picture | overlay | both |
    /// |---|---|---|---|---|
    /// | force | yes | – | – | yes |
    /// | inside | – | yes | – | yes |
    /// | target | – | yes | yes | yes |
    /// | readings | – | – | yes | yes |
    /// | captions | – | – | yes | yes |
    /// | sound | – | – | yes | yes |
    /// | coaching | – | – | yes | yes |
    #[must_use]
    pub const fn gives(self, channel: Channel) -> bool {
        let [force, picture, overlay, both] = match channel {
            Channel::Force => [true, false, false, true],
            Channel::Inside => [false, true, false, true],
            Channel::Target => [false, true, true, true],
            Channel::Readings | Channel::Captions | Channel::Sound | Channel::Coaching => [false, false, true, true],
        };
        match self {
            Self::Force => force,
            Self::Picture => picture,
            Self::Overlay => overlay,
            Self::Both => both,
        }
    }

    /// In words, for the person before the attempt.
    #[must_use]
    pub const fn in_words(self) -> &'static str {
        match self {
            Self::Force => sentence!(
                "force in your hand; the picture shows the body from outside, and nothing is said or heard of it"
            ),
            Self::Picture => {
                sentence!("the picture shows the inside of the body and the target; your hand feels nothing")
            }
            Self::Overlay => {
                sentence!("depth, force, layer and target are shown, pops are named; your hand feels nothing")
            }
            Self::Both => sentence!("force in your hand, the inside of the body, depth, force and layer"),
        }
    }
}

#[cfg(test)]
mod tests {
    //! A study that compares what trainees are given measures nothing if a channel that is closed tells anyway. The window's tests hold that
    //! each channel asks here.

    use super::*;

    fn open(feedback: Feedback) -> Vec<Channel> {
        Channel::ALL.into_iter().filter(|channel| feedback.gives(*channel)).collect()
    }

    #[test]
    fn force_alone_is_force_alone_and_both_is_everything() {
        assert_eq!(open(Feedback::Force), [Channel::Force]);
        assert_eq!(open(Feedback::Picture), [Channel::Inside, Channel::Target]);
        assert!(
            !open(Feedback::Overlay).contains(&Channel::Force) && !open(Feedback::Overlay).contains(&Channel::Inside)
        );
        assert_eq!(open(Feedback::Both), Channel::ALL);
        for channel in Channel::ALL {
            assert!(Feedback::ALL.iter().any(|mode| !mode.gives(channel)), "{channel:?} can be withheld");
        }
    }
}
