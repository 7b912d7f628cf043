//! The publications of the figures.

use phrase::sentence;

/// Provenance of a figure in this list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HowKnown {
    /// The abstract was read and contains the figure.
    Abstract,
    /// A record of the measurement was read and contains the figure.
    Record,
    /// The figure was recalled without reading the publication and may be wrong.
    Recalled,
}

impl HowKnown {
    /// Describes the provenance in words.
    #[must_use]
    pub const fn words(self) -> &'static str {
        match self {
            Self::Abstract => sentence!("abstract read"),
            Self::Record => sentence!("record read"),
            Self::Recalled => sentence!("recalled, not read"),
        }
    }
}

/// A publication.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MeasurementSource {
    /// Authors, year, title and journal, as far as known.
    pub citation: &'static str,
    /// DOI; empty if unknown.
    pub doi: &'static str,
    /// Provenance.
    pub known: HowKnown,
}

pub(crate) const RENAL_ACCESS: MeasurementSource = MeasurementSource {
    citation: "Development of a synthetic model of percutaneous renal access from forces in fresh human cadavers. Journal of Endourology, 2016",
    doi: "10.1089/end.2016.0342",
    known: HowKnown::Abstract,
};

pub(crate) const VERESS: MeasurementSource = MeasurementSource {
    citation: "Force required for Veress needle entry using digital force gauge during laparoscopy: pilot study. Medical Research Archives",
    doi: "",
    known: HowKnown::Abstract,
};

pub(crate) const TUOHY_PORCINE: MeasurementSource = MeasurementSource {
    citation: "N. Vaughan, V. N. Dubey, M. Y. K. Wee, R. Isaacs: Measuring Tuohy needle insertion force on a porcine spine, 2012",
    doi: "",
    known: HowKnown::Abstract,
};

pub(crate) const FLAVUM_SPEED: MeasurementSource = MeasurementSource {
    citation: "K. Naemura, H. Saito: Needle insertion test by porcine ligamentum flavum. IFMBE Proceedings 25/6, 2009",
    doi: "10.1007/978-3-642-03906-5_9",
    known: HowKnown::Abstract,
};

pub(crate) const EPIDURAL_PROFILE: MeasurementSource = MeasurementSource {
    citation: "Force along the way to the lumbar epidural space, patient of 71 kg",
    doi: "",
    known: HowKnown::Recalled,
};

pub(crate) const FRACTURE_SHARES: MeasurementSource = MeasurementSource {
    citation: "A. C. Barnett, Y.-S. Lee, J. Z. Moore: Fracture mechanics model of needle cutting tissue. Journal of Manufacturing Science and Engineering, 2015",
    doi: "10.1115/1.4030374",
    known: HowKnown::Abstract,
};

pub(crate) const LIVER_TOUGHNESS: MeasurementSource = MeasurementSource {
    citation: "C. Gokgol, C. Basdogan, D. Canadinc: Estimation of fracture toughness of liver tissue: experiments and validation. Medical Engineering and Physics 34 (2012) 882–891",
    doi: "10.1016/j.medengphy.2011.09.030",
    known: HowKnown::Abstract,
};

pub(crate) const LIVER_KIDNEY: MeasurementSource = MeasurementSource {
    citation: "Y. Wang, X. Xie, Y. Wan, E. Guan: Dynamic force modeling and lateral perturbation analysis of needle insertion into soft tissues. Bioengineering, 2026",
    doi: "10.3390/bioengineering13030266",
    known: HowKnown::Abstract,
};

pub(crate) const LIVER_HOLD: MeasurementSource = MeasurementSource {
    citation: "A. M. Okamura, C. Simone, M. D. O'Leary: Force modeling for needle insertion into soft tissue. IEEE Transactions on Biomedical Engineering 51, 2004, as the public data set amartsop/dataset_lib has it",
    doi: "10.1109/TBME.2004.831542",
    known: HowKnown::Record,
};

pub(crate) const FEEDBACK_OVERSHOOT: MeasurementSource = MeasurementSource {
    citation: "O. Gerovichev, P. Marayong, A. M. Okamura: The effect of visual and haptic feedback on computer-assisted needle insertion. Computer Aided Surgery, 2004",
    doi: "10.3109/10929080500190441",
    known: HowKnown::Abstract,
};

pub(crate) const RESPONSE_TIMES: MeasurementSource = MeasurementSource {
    citation: "Exploring human response times to combinations of audio, haptic, and visual stimuli from a mobile device. World Haptics Conference, 2023",
    doi: "",
    known: HowKnown::Abstract,
};

pub(crate) const DURA_EDGE: MeasurementSource = MeasurementSource {
    citation: "M. C. Lewis, J. P. Lafferty, M. S. Sacks, V. S. Pallares, M. TerRiet: How much work is required to puncture dura with Tuohy needles? British Journal of Anaesthesia 85 (2000) 238–241",
    doi: "10.1093/bja/85.2.238",
    known: HowKnown::Abstract,
};

pub(crate) const DURA_STRENGTH: MeasurementSource = MeasurementSource {
    citation: "E. Zarzur: Mechanical properties of the human lumbar dura mater. Arquivos de Neuro-Psiquiatria 54 (1996) 455–460",
    doi: "",
    known: HowKnown::Abstract,
};
