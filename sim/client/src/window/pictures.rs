//! The pictures of a briefing: decoded in a background thread, then shown below the text.

use std::sync::mpsc::{Receiver, channel};
use std::thread;

use documents::picture::{PictureFile, PicturePixels, decode_picture};
use documents::{ExerciseBundle, ExercisePicture};
use eframe::egui::{self, ColorImage, RichText, TextureHandle, TextureOptions, Ui};
use phrase::Phrase;

use super::choose::own_words;
use super::colours;

/// Longest side of a picture shown, in pixels: sharp at twice the width of the column, and within
/// the limits of every graphics card.
const MOST_SIDE: u32 = 1080;

/// The pictures of the current briefing.
#[derive(Default)]
pub struct BriefingPictures {
    /// Digest of the exercise's document.
    exercise: String,
    /// Decoded pictures still to arrive, in order.
    arriving: Option<Receiver<Decoded>>,
    shown: Vec<BriefingPicture>,
}

/// A picture with its description.
struct BriefingPicture {
    named: ExercisePicture,
    state: PictureState,
}

/// State of a picture.
enum PictureState {
    Decoding,
    Ready(TextureHandle),
    Unreadable(Phrase),
}

/// A decoded picture, or the reason why it cannot be shown.
type Decoded = Result<PicturePixels, Phrase>;

impl BriefingPictures {
    /// Returns the pictures of an exercise. They are decoded once, when its briefing is opened.
    pub fn of(&mut self, bundle: &ExerciseBundle) -> &mut Self {
        if self.exercise != bundle.exercise.sha256 {
            bundle.exercise.sha256.clone_into(&mut self.exercise);
            self.shown = bundle.exercise.pictures.iter().map(BriefingPicture::new).collect();
            self.arriving = (!bundle.pictures.is_empty()).then(|| begin_decoding(bundle.pictures.clone()));
        }
        self
    }

    /// Shows the pictures below each other, at most as wide as the column.
    pub fn show(&mut self, ui: &mut Ui) {
        self.take_arrived(ui.ctx());
        for picture in &self.shown {
            ui.add_space(16.0);
            picture.show(ui);
        }
    }

    /// Takes the pictures that were decoded since the last frame.
    fn take_arrived(&mut self, context: &egui::Context) {
        let Some(arriving) = &self.arriving else { return };
        let mut waiting = self.shown.iter_mut().filter(|picture| matches!(picture.state, PictureState::Decoding));
        for decoded in arriving.try_iter() {
            if let Some(picture) = waiting.next() {
                picture.state = PictureState::of_decoded(context, &picture.named.file, decoded);
            }
        }
        match waiting.next() {
            Some(_) => context.request_repaint_after(std::time::Duration::from_millis(50)),
            None => self.arriving = None,
        }
    }
}

impl BriefingPicture {
    fn new(named: &ExercisePicture) -> Self {
        Self { named: named.clone(), state: PictureState::Decoding }
    }

    fn show(&self, ui: &mut Ui) {
        let alt = own_words(&self.named.alt);
        match &self.state {
            PictureState::Ready(texture) => {
                let image = egui::Image::new(texture).max_width(ui.available_width()).alt_text(alt);
                ui.add(image).on_hover_text(alt);
            }
            PictureState::Decoding => drop(ui.label(RichText::new(alt).weak())),
            PictureState::Unreadable(why) => {
                ui.label(alt);
                ui.colored_label(colours::WARN, format!("× {}", words::phrase(why)));
            }
        }
        if let Some(caption) = &self.named.caption {
            ui.label(RichText::new(own_words(caption)).weak());
        }
    }
}

impl PictureState {
    fn of_decoded(context: &egui::Context, name: &str, decoded: Decoded) -> Self {
        let PicturePixels { size: [width, height], rgba } = match decoded {
            Ok(pixels) => pixels,
            Err(why) => return Self::Unreadable(why),
        };
        let image = ColorImage::from_rgba_unmultiplied([width as usize, height as usize], &rgba);
        Self::Ready(context.load_texture(name, image, TextureOptions::LINEAR))
    }
}

/// Decodes pictures one after the other in a background thread, which ends when the receiver is
/// dropped.
fn begin_decoding(pictures: Vec<PictureFile>) -> Receiver<Decoded> {
    let (sender, receiver) = channel();
    thread::spawn(move || {
        for picture in pictures {
            let decoded = decode_picture(&picture.bytes, MOST_SIDE);
            if sender.send(decoded).is_err() {
                return;
            }
        }
    });
    receiver
}

#[cfg(test)]
mod tests {
    //! Fails if a picture of the author's is missing, smaller than the space for it, or without its
    //! description.

    use eframe::egui::{Context, RawInput, Rect, pos2};
    use image::{DynamicImage, ImageFormat, RgbImage};

    use super::*;

    /// The shipped exercise with another briefing: a wide picture, and one that cannot be decoded.
    fn bundle() -> ExerciseBundle {
        let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("../../curricula/lower-back-basics/2-stop-in-the-fat.toml");
        let mut bundle = ExerciseBundle::read(&file).expect("a shipped exercise");
        let mut bytes = std::io::Cursor::new(Vec::new());
        DynamicImage::from(RgbImage::new(1600, 400)).write_to(&mut bytes, ImageFormat::Png).expect("a PNG");
        let named = |file: &str| ExercisePicture {
            file: file.to_owned(),
            alt: format!("What {file} shows").into(),
            caption: None,
        };
        bundle.exercise.pictures = vec![named("a.png"), named("b.png")];
        let file = |name: &str, bytes| PictureFile { name: name.to_owned(), size: [1600, 400], bytes };
        bundle.pictures = vec![file("a.png", bytes.into_inner()), file("b.png", b"none".to_vec())];
        bundle
    }

    #[test]
    fn pictures_decode_in_the_background_and_fill_the_column() {
        let (context, bundle, mut pictures) = (Context::default(), bundle(), BriefingPictures::default());
        let mut width = 0.0;
        let mut frame = |pictures: &mut BriefingPictures| {
            let screen_rect = Some(Rect::from_min_max(pos2(0.0, 0.0), pos2(1280.0, 800.0)));
            let input = RawInput { screen_rect, ..RawInput::default() };
            let mut drawn = context.run_ui(input, |ui| {
                ui.set_max_width(540.0);
                pictures.of(&bundle).show(ui);
                width = ui.min_rect().width();
            });
            let sizes = drawn
                .textures_delta
                .set
                .values()
                .flat_map(|deltas| deltas.iter().map(|delta| delta.image.size()))
                .collect::<Vec<_>>();
            drawn.textures_delta.clear();
            sizes
        };
        let mut textures = frame(&mut pictures);
        while pictures.arriving.is_some() {
            textures.extend(frame(&mut pictures));
        }
        textures.extend(frame(&mut pictures));
        assert!(textures.contains(&[1080, 270]), "{textures:?}");
        let [first, second] = pictures.shown.as_slice() else { panic!("two pictures") };
        assert!(matches!(first.state, PictureState::Ready(_)));
        assert!(
            matches!(&second.state, PictureState::Unreadable(why) if why.to_string().contains("neither PNG nor JPEG"))
        );
        assert!((500.0..=560.0).contains(&width), "{width}");
        assert!(textures.iter().filter(|size| **size == [1080, 270]).count() == 1, "decoded once: {textures:?}");
    }
}
