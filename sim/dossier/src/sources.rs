//! The publications of the figures.

use phrase::sentence;

/// Provenance of a figure in this list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Provenance {
    /// The abstract was read and contains the figure.
    Abstract,
    /// A record of the measurement was read and contains the figure.
    Record,
    /// The figure was recalled without reading the publication and may be wrong.
    Recalled,
}

impl Provenance {
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
    pub known: Provenance,
}

impl MeasurementSource {
    /// Returns the DOI or, without one, the citation.
    pub(crate) fn short(&self) -> String {
        if self.doi.is_empty() { self.citation.to_owned() } else { format!("DOI {}", self.doi) }
    }
}

pub(crate) const RENAL_ACCESS: MeasurementSource = MeasurementSource {
    citation: "Development of a synthetic model of percutaneous renal access from forces in fresh human cadavers. Journal of Endourology, 2016",
    doi: "10.1089/end.2016.0342",
    known: Provenance::Abstract,
};

pub(crate) const VERESS: MeasurementSource = MeasurementSource {
    citation: "Force required for Veress needle entry using digital force gauge during laparoscopy: pilot study. Medical Research Archives",
    doi: "",
    known: Provenance::Abstract,
};

pub(crate) const TROCAR_ENTRY: MeasurementSource = MeasurementSource {
    citation: "J. Fanning, M. Shah, B. Fenton: Reduced-force closed trocar entry technique. JSLS 15 (2011) 59–61",
    doi: "10.4293/108680811X13022985131219",
    known: Provenance::Abstract,
};

pub(crate) const FIVE_TROCARS: MeasurementSource = MeasurementSource {
    citation: "Interactive 3D force and torque of primary trocar insertion in patients, Ramathibodi Hospital",
    doi: "",
    known: Provenance::Abstract,
};

pub(crate) const SWINE_TROCARS: MeasurementSource = MeasurementSource {
    citation: "Trocar entry forces and defects in swine, six 12 mm trocars. Obstetrics & Gynecology, 1999",
    doi: "10.1016/s0029-7844(99)00288-4",
    known: Provenance::Abstract,
};

pub(crate) const LUBRICANTS: MeasurementSource = MeasurementSource {
    citation: "L. W. Schneider, L. S. Peck, J. W. Melvin: Penetration characteristics of hypodermic needles in skin and muscle tissue. UM-HSRI-78-23, 1978",
    doi: "",
    known: Provenance::Abstract,
};

pub(crate) const PRONE_CALYX: MeasurementSource = MeasurementSource {
    citation: "Sofer et al.: distance from skin to calyx on computed tomography, 20 patients. Journal of Urology, 2016",
    doi: "10.1016/j.juro.2015.07.101",
    known: Provenance::Abstract,
};

pub(crate) const SKIN_THICKNESS: MeasurementSource = MeasurementSource {
    citation: "Thickness of human skin by ultrasound of 20 MHz, 342 people. Vaccine 25 (2007) 6423",
    doi: "10.1016/j.vaccine.2007.05.046",
    known: Provenance::Abstract,
};

pub(crate) const EPIDURAL_DEPTH: MeasurementSource = MeasurementSource {
    citation: "Ekja et al.: depth of the lumbar epidural space by magnetic resonance, 2004",
    doi: "",
    known: Provenance::Abstract,
};

pub(crate) const FLAVUM_THICKNESS: MeasurementSource = MeasurementSource {
    citation: "Thickness of the ligamentum flavum from L2 to S1",
    doi: "10.5603/FM.a2021.0120",
    known: Provenance::Abstract,
};

pub(crate) const LABOUR_PRESSURE: MeasurementSource = MeasurementSource {
    citation: "M. Y. K. Wee et al.: epidural insertion pressure in labour by body mass index. International Journal of Clinical Anesthesia and Research, 2017",
    doi: "10.29328/journal.ijcar.1001004",
    known: Provenance::Abstract,
};

pub(crate) const DURA_CLICKS: MeasurementSource = MeasurementSource {
    citation: "Utsumi, Hascilowicz, Omi: click of fine spinal needles through dura. PLOS ONE, 2021",
    doi: "10.1371/journal.pone.0247346",
    known: Provenance::Abstract,
};

pub(crate) const TUOHY_PORCINE: MeasurementSource = MeasurementSource {
    citation: "N. Vaughan, V. N. Dubey, M. Y. K. Wee, R. Isaacs: Measuring Tuohy needle insertion force on a porcine spine, 2012",
    doi: "",
    known: Provenance::Abstract,
};

pub(crate) const FLAVUM_SPEED: MeasurementSource = MeasurementSource {
    citation: "K. Naemura, H. Saito: Needle insertion test by porcine ligamentum flavum. IFMBE Proceedings 25/6, 2009",
    doi: "10.1007/978-3-642-03906-5_9",
    known: Provenance::Abstract,
};

pub(crate) const EPIDURAL_PROFILE: MeasurementSource = MeasurementSource {
    citation: "nitsanti: Epidural-Simulator-Code (EpiduralSimulator.cpp), which names Brazil et al.",
    doi: "",
    known: Provenance::Record,
};

pub(crate) const FRACTURE_SHARES: MeasurementSource = MeasurementSource {
    citation: "A. C. Barnett, Y.-S. Lee, J. Z. Moore: Fracture mechanics model of needle cutting tissue. Journal of Manufacturing Science and Engineering, 2015",
    doi: "10.1115/1.4030374",
    known: Provenance::Abstract,
};

pub(crate) const LIVER_TOUGHNESS: MeasurementSource = MeasurementSource {
    citation: "C. Gokgol, C. Basdogan, D. Canadinc: Estimation of fracture toughness of liver tissue: experiments and validation. Medical Engineering and Physics 34 (2012) 882–891",
    doi: "10.1016/j.medengphy.2011.09.030",
    known: Provenance::Abstract,
};

pub(crate) const LIVER_KIDNEY: MeasurementSource = MeasurementSource {
    citation: "Y. Wang, X. Xie, Y. Wan, E. Guan: Dynamic force modeling and lateral perturbation analysis of needle insertion into soft tissues. Bioengineering, 2026",
    doi: "10.3390/bioengineering13030266",
    known: Provenance::Abstract,
};

pub(crate) const LIVER_HOLD: MeasurementSource = MeasurementSource {
    citation: "A. M. Okamura, C. Simone, M. D. O'Leary: Force modeling for needle insertion into soft tissue. IEEE Transactions on Biomedical Engineering 51, 2004, as the public data set amartsop/dataset_lib has it",
    doi: "10.1109/TBME.2004.831542",
    known: Provenance::Record,
};

pub(crate) const FEEDBACK_OVERSHOOT: MeasurementSource = MeasurementSource {
    citation: "O. Gerovichev, P. Marayong, A. M. Okamura: The effect of visual and haptic feedback on computer-assisted needle insertion. Computer Aided Surgery, 2004",
    doi: "10.3109/10929080500190441",
    known: Provenance::Abstract,
};

pub(crate) const RESPONSE_TIMES: MeasurementSource = MeasurementSource {
    citation: "Exploring human response times to combinations of audio, haptic, and visual stimuli from a mobile device. World Haptics Conference, 2023",
    doi: "",
    known: Provenance::Abstract,
};

pub(crate) const DURA_EDGE: MeasurementSource = MeasurementSource {
    citation: "M. C. Lewis, J. P. Lafferty, M. S. Sacks, V. S. Pallares, M. TerRiet: How much work is required to puncture dura with Tuohy needles? British Journal of Anaesthesia 85 (2000) 238–241",
    doi: "10.1093/bja/85.2.238",
    known: Provenance::Abstract,
};

pub(crate) const DURA_STRENGTH: MeasurementSource = MeasurementSource {
    citation: "E. Zarzur: Mechanical properties of the human lumbar dura mater. Arquivos de Neuro-Psiquiatria 54 (1996) 455–460",
    doi: "",
    known: Provenance::Abstract,
};
