//! A question and its input: marks on a line, a list, or a field.

use assessment::questionnaire::{Answer, Refused, read_answer};
use documents::Instrument;
use documents::instrument::{Item, ScaleKind, Words};
use eframe::egui::{
    self, Align, EventFilter, Key, Layout, RichText, Sense, Stroke, TextEdit, Ui, WidgetInfo, pos2, vec2,
};

use crate::window::colours;

/// Maximum number of marks on a line; a finer scale is a field for a number.
const MOST_MARKS: usize = 21;
/// Length of a line of marks, in points.
const LINE: f32 = 300.0;

/// Text typed into a field, and the reason why it is not a valid answer.
#[derive(Clone, Debug, Default)]
pub struct Typed {
    text: String,
    refused: Option<Refused>,
}

/// A question of an instrument, in a language.
#[derive(Clone, Copy)]
pub struct Question<'a> {
    pub instrument: &'a Instrument,
    pub item: &'a Item,
    pub language: &'a str,
}

impl Question<'_> {
    fn read(&self, words: &Words) -> String {
        words.in_language(self.language).to_owned()
    }

    /// Shows one frame; returns true if the answer has changed.
    pub fn ui(&self, ui: &mut Ui, answer: &mut Option<Answer>, typed: &mut Typed) -> bool {
        let Some(scale) = self.instrument.scale(self.item) else { return false };
        ui.add_space(10.0);
        if let Some(name) = &self.item.name {
            ui.label(RichText::new(self.read(name)).strong());
        }
        ui.label(self.read(&self.item.text));
        let said = ui.push_id(&self.item.id, |ui| self.field(ui, scale, answer.as_ref(), typed)).inner;
        let Some(said) = said else { return false };
        let said: Vec<&str> = said.iter().map(String::as_str).collect();
        match read_answer(self.item, scale, &said) {
            Ok(read) => {
                typed.refused = None;
                *answer = read;
            }
            Err(why) => {
                typed.refused = Some(why);
                *answer = None;
            }
        }
        true
    }

    /// Shows the input of a question; returns the new answer, if it was changed.
    fn field(&self, ui: &mut Ui, scale: &ScaleKind, answer: Option<&Answer>, typed: &mut Typed) -> Option<Vec<String>> {
        match scale {
            ScaleKind::Likert { points, labels, first, last, .. } if labels.is_empty() => {
                let marks: Vec<f64> = (1..=*points).map(f64::from).collect();
                self.line(ui, &marks, answer, [first.as_ref(), last.as_ref()])
            }
            ScaleKind::Likert { labels, .. } => {
                let options = (1..).zip(labels).map(|(point, label)| (point.to_string(), self.read(label)));
                let chosen = answer.and_then(Answer::number).map(|number| number.to_string());
                choose_one_option(ui, options, chosen.as_deref())
            }
            ScaleKind::Slider { min, max, step, first, last } => {
                let marks =
                    (0..=MOST_MARKS).map(|n| min + n as f64 * step).take_while(|mark| *mark <= max + step * 1e-6);
                let marks: Vec<f64> = marks.collect();
                if marks.len() > MOST_MARKS {
                    return enter_number(ui, typed, &words::decimal(&format!("{min} – {max}")));
                }
                self.line(ui, &marks, answer, [first.as_ref(), last.as_ref()])
            }
            ScaleKind::Number { min, max, unit } => {
                enter_number(ui, typed, &words::decimal(&format!("{min} – {max} {unit}")))
            }
            ScaleKind::Pair => {
                let named = |id: &String| Some((id.clone(), self.read(self.instrument.item(id)?.1.short())));
                choose_one_option(ui, self.item.pair.iter().filter_map(named), text_of(answer))
            }
            ScaleKind::Choice { options } => {
                let options = options.iter().map(|option| (option.id.clone(), self.read(&option.text)));
                choose_one_option(ui, options, text_of(answer))
            }
            ScaleKind::Choices { options } => {
                let options = options.iter().map(|option| (option.id.clone(), self.read(&option.text)));
                choose_several_options(ui, options, answer)
            }
            ScaleKind::Text { max_characters } => {
                let field = TextEdit::multiline(&mut typed.text).desired_rows(3).desired_width(f32::INFINITY);
                ui.add(field.char_limit(*max_characters)).changed().then(|| vec![typed.text.clone()])
            }
        }
    }

    /// Shows a line of marks between two ends. No mark is set initially, since that would be an
    /// answer already.
    fn line(
        &self,
        ui: &mut Ui,
        marks: &[f64],
        answer: Option<&Answer>,
        ends: [Option<&Words>; 2],
    ) -> Option<Vec<String>> {
        let chosen = answer.and_then(Answer::number);
        let at = chosen.and_then(|chosen| marks.iter().position(|mark| (mark - chosen).abs() < 1e-9));
        let mut set = at;
        let [first, last] = ends.map(|end| end.map_or_else(String::new, |words| self.read(words)));
        ui.horizontal(|ui| {
            set = draw_line(ui, marks, at, self.item.text.in_language(self.language));
            if let Some(chosen) = chosen {
                ui.label(RichText::new(words::decimal(&chosen.to_string())).strong());
                if ui.small_button("×").clicked() {
                    set = None;
                }
            }
        });
        // The text of each end is below it.
        ui.allocate_ui(vec2(LINE, 0.0), |ui| {
            ui.columns(2, |halves| {
                halves[0].label(RichText::new(first).weak().small());
                let right = Layout::top_down(Align::RIGHT);
                halves[1].with_layout(right, |ui| ui.label(RichText::new(last).weak().small()));
            });
        });
        (set != at).then(|| set.map_or_else(Vec::new, |at| vec![marks[at].to_string()]))
    }
}

/// Draws a line of marks with the selected one, and reads pointer and arrow keys; returns the mark
/// selected now.
fn draw_line(ui: &mut Ui, marks: &[f64], at: Option<usize>, name: &str) -> Option<usize> {
    let (area, response) = ui.allocate_exact_size(vec2(LINE, 26.0), Sense::click_and_drag());
    let last = marks.len().saturating_sub(1);
    let line = area.shrink2(vec2(9.0, 0.0));
    let x = |at: usize| egui::lerp(line.x_range(), at as f32 / last.max(1) as f32);
    let strong = response.hovered() || response.has_focus();
    let ground = Stroke::new(if strong { 2.0 } else { 1.0 }, ui.visuals().weak_text_color());
    ui.painter().hline(line.x_range(), area.center().y, ground);
    for mark in 0..marks.len() {
        ui.painter().vline(x(mark), area.center().y - 6.0..=area.center().y + 6.0, ground);
    }
    if let Some(at) = at {
        ui.painter().circle_filled(pos2(x(at), area.center().y), 7.0, colours::FORCE);
    }
    response.widget_info(|| WidgetInfo { value: at.map(|at| marks[at]), ..WidgetInfo::slider(true, 0.0, name) });
    // The arrow keys move the mark, not the focus.
    let arrows = EventFilter { horizontal_arrows: true, ..EventFilter::default() };
    ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, arrows));
    let pointed = response.interact_pointer_pos().map(|pointer| {
        let share = ((pointer.x - line.left()) / line.width()).clamp(0.0, 1.0);
        (share * last as f32).round() as usize
    });
    let step = |key: Key| response.has_focus() && ui.input(|input| input.key_pressed(key));
    if pointed.is_some() {
        pointed
    } else if step(Key::ArrowRight) {
        Some(at.map_or(0, |at| (at + 1).min(last)))
    } else if step(Key::ArrowLeft) {
        Some(at.map_or(last, |at| at.saturating_sub(1)))
    } else {
        at
    }
}

fn text_of(answer: Option<&Answer>) -> Option<&str> {
    match answer {
        Some(Answer::Text(id)) => Some(id),
        _ => None,
    }
}

/// Shows a list to choose one option from; choosing it again removes the answer.
fn choose_one_option(
    ui: &mut Ui,
    options: impl Iterator<Item = (String, String)>,
    chosen: Option<&str>,
) -> Option<Vec<String>> {
    let mut said = None;
    for (id, label) in options {
        let is_chosen = chosen == Some(id.as_str());
        if ui.radio(is_chosen, label).clicked() {
            said = Some(if is_chosen { Vec::new() } else { vec![id] });
        }
    }
    said
}

fn choose_several_options(
    ui: &mut Ui,
    options: impl Iterator<Item = (String, String)>,
    answer: Option<&Answer>,
) -> Option<Vec<String>> {
    let before = if let Some(Answer::Several(ids)) = answer { ids.clone() } else { Vec::new() };
    let mut now = before.clone();
    for (id, label) in options {
        let mut ticked = before.contains(&id);
        if ui.checkbox(&mut ticked, label).changed() {
            now.retain(|known| *known != id);
            now.extend(ticked.then_some(id));
        }
    }
    (now != before).then_some(now)
}

fn enter_number(ui: &mut Ui, typed: &mut Typed, allowed: &str) -> Option<Vec<String>> {
    let changed = ui.horizontal(|ui| {
        let changed = ui.add(TextEdit::singleline(&mut typed.text).desired_width(80.0)).changed();
        ui.label(RichText::new(allowed).weak());
        changed
    });
    if let Some(why) = &typed.refused {
        ui.colored_label(colours::WARN, format!("▲ {}", words::phrase(&why.phrase())));
    }
    changed.inner.then(|| vec![typed.text.clone()])
}
