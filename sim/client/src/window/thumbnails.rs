//! The pictures of the list: the first picture of an exercise's author, else a section along its
//! planned path. A background thread draws a picture when its row is first in view.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread;

use documents::ExerciseBundle;
use documents::picture::{PicturePixels, decode_picture};
use eframe::egui::{self, ColorImage, CornerRadius, Image, Rect, Sense, TextureHandle, TextureOptions, Ui, Vec2};

use super::choose::own_words;
use crate::picture;

/// Size of a picture on the list, in points.
const SIZE: Vec2 = Vec2::new(80.0, 50.0);
const CORNER: CornerRadius = CornerRadius::same(4);
/// Longest side of an author's picture, in pixels: at least twice the size on the list.
const MOST_SIDE: u32 = 256;

/// The pictures of the list, as far as they were needed.
#[derive(Default)]
pub struct Thumbnails {
    /// By the digest of the exercise's document; `None` while a picture is being drawn.
    pictures: BTreeMap<String, Option<TextureHandle>>,
    artist: Option<Artist>,
}

/// A background thread that draws pictures one after the other, until this is dropped.
struct Artist {
    wanted: Sender<Arc<ExerciseBundle>>,
    drawn: Receiver<(String, PicturePixels)>,
}

impl Thumbnails {
    /// Shows the picture of an exercise, or its empty place while the picture is being drawn.
    pub fn show(&mut self, ui: &mut Ui, bundle: &Arc<ExerciseBundle>) {
        let (place, _) = ui.allocate_exact_size(SIZE, Sense::hover());
        if !ui.is_rect_visible(place) {
            return;
        }
        self.take_drawn(ui.ctx());
        match self.pictures.get(&bundle.exercise.sha256) {
            Some(Some(texture)) => {
                let author = bundle.exercise.pictures.first().filter(|_| !bundle.pictures.is_empty());
                let alt = author.map_or(tr!("The body cut open along the planned path"), |named| own_words(&named.alt));
                let image = Image::new(texture).uv(fill(texture.size_vec2())).corner_radius(CORNER).alt_text(alt);
                ui.put(place, image.fit_to_exact_size(SIZE).maintain_aspect_ratio(false));
            }
            Some(None) => {
                ui.painter().rect_filled(place, CORNER, ui.visuals().faint_bg_color);
                ui.ctx().request_repaint_after_secs(0.05);
            }
            None => {
                let artist = self.artist.get_or_insert_with(Artist::start);
                // Without the thread the place stays empty.
                let waits = artist.wanted.send(Arc::clone(bundle)).is_ok();
                self.pictures.insert(bundle.exercise.sha256.clone(), None);
                if waits {
                    ui.ctx().request_repaint();
                }
            }
        }
    }

    /// Takes the pictures that were drawn since the last frame.
    fn take_drawn(&mut self, context: &egui::Context) {
        for (exercise, PicturePixels { size, rgba }) in self.artist.iter().flat_map(|artist| artist.drawn.try_iter()) {
            let image = ColorImage::from_rgba_unmultiplied(size.map(|side| side as usize), &rgba);
            let texture = context.load_texture(&exercise, image, TextureOptions::LINEAR);
            self.pictures.insert(exercise, Some(texture));
        }
    }
}

impl Artist {
    fn start() -> Self {
        let (wanted, orders) = channel::<Arc<ExerciseBundle>>();
        let (sender, drawn) = channel();
        thread::spawn(move || {
            for bundle in orders {
                if sender.send((bundle.exercise.sha256.clone(), draw(&bundle))).is_err() {
                    return;
                }
            }
        });
        Self { wanted, drawn }
    }
}

fn draw(bundle: &ExerciseBundle) -> PicturePixels {
    let author = bundle.pictures.first().and_then(|file| decode_picture(&file.bytes, MOST_SIDE).ok());
    author.unwrap_or_else(|| picture::draw_section(bundle))
}

/// Returns the part of a picture, from 0 to 1, that fills the place on the list: the middle.
fn fill(picture: Vec2) -> Rect {
    let scale = SIZE / picture;
    let part = scale / scale.max_elem();
    Rect::from_center_size(egui::pos2(0.5, 0.5), part)
}

#[cfg(test)]
mod tests {
    //! Fails if a picture is drawn before its row is in view or twice, or if it is distorted.

    use std::path::Path;

    use eframe::egui::{Context, RawInput, pos2, vec2};

    use super::*;

    fn bundle(name: &str) -> Arc<ExerciseBundle> {
        let course = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../curricula/lower-back-basics");
        Arc::new(ExerciseBundle::read(&course.join(name)).expect("a shipped exercise"))
    }

    #[test]
    fn pictures_are_drawn_once_and_only_in_view() {
        let (context, mut thumbnails) = (Context::default(), Thumbnails::default());
        let bundles = ["1-feel-the-layers.toml", "6-avoid-the-vessel.toml", "2-stop-in-the-fat.toml"].map(bundle);
        let mut sizes = Vec::new();
        let mut frame = |thumbnails: &mut Thumbnails| {
            let screen_rect = Some(Rect::from_min_size(pos2(0.0, 0.0), vec2(400.0, 130.0)));
            let mut drawn = context.run_ui(RawInput { screen_rect, ..RawInput::default() }, |ui| {
                ui.set_clip_rect(Rect::from_min_size(pos2(0.0, 0.0), vec2(400.0, 100.0)));
                bundles.iter().for_each(|bundle| thumbnails.show(ui, bundle));
            });
            let deltas = drawn.textures_delta.set.values().flatten().map(|delta| delta.image.size());
            sizes.extend(deltas.filter(|size| size[0] < 300 && size[1] > 100));
            drawn.textures_delta.clear();
        };
        while thumbnails.pictures.len() < 2 || thumbnails.pictures.values().any(Option::is_none) {
            frame(&mut thumbnails);
        }
        (0..3).for_each(|_| frame(&mut thumbnails));
        assert_eq!(thumbnails.pictures.len(), 2, "the third is out of view");
        assert_eq!(sizes, [[192, 120], [256, 160]], "a section, and the author's own picture");
    }

    #[test]
    fn a_picture_keeps_its_proportions() {
        for size in [vec2(720.0, 450.0), vec2(300.0, 300.0), vec2(1000.0, 200.0)] {
            let shown = fill(size).size() * size;
            assert!((shown.x / shown.y - SIZE.x / SIZE.y).abs() < 1e-3, "{size:?}: {shown:?}");
            assert!(fill(size).max.x <= 1.0 && fill(size).max.y <= 1.0);
        }
    }
}
