-- Exams at one station: an examiner rates each candidate of a cohort with an instrument, within a time limit; a second
-- rater rates the recorded attempts in a blinded round.
CREATE TABLE exams (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL REFERENCES schools (id),
    title TEXT NOT NULL CHECK (length(trim(title)) > 0),
    cohort_id BLOB NOT NULL,
    exercise_id TEXT NOT NULL,
    revision_id BLOB NOT NULL, -- of the instrument
    limit_min INTEGER NOT NULL CHECK (limit_min BETWEEN 1 AND 120),
    second_rater_id BLOB, -- absent: each candidate is rated once
    round_id BLOB, -- of the second ratings; absent: none were requested
    made_by BLOB NOT NULL,
    made_at INTEGER NOT NULL,
    closed_at INTEGER,
    UNIQUE (school_id, id),
    FOREIGN KEY (school_id, cohort_id) REFERENCES cohorts (school_id, id),
    FOREIGN KEY (school_id, exercise_id) REFERENCES exercises (school_id, exercise_id),
    FOREIGN KEY (school_id, revision_id) REFERENCES instrument_revisions (school_id, id),
    FOREIGN KEY (school_id, second_rater_id) REFERENCES people (school_id, id),
    FOREIGN KEY (school_id, round_id) REFERENCES rating_rounds (school_id, id),
    FOREIGN KEY (school_id, made_by) REFERENCES people (school_id, id)
) STRICT;

CREATE INDEX exams_by_time ON exams (school_id, made_at);
CREATE INDEX exams_by_maker ON exams (school_id, made_by);
CREATE INDEX exams_by_second_rater ON exams (school_id, second_rater_id);
CREATE INDEX exams_by_round ON exams (round_id) WHERE round_id IS NOT NULL;

-- One candidate at the station. The examiner and the times are those of the service.
CREATE TABLE exam_sittings (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL,
    exam_id BLOB NOT NULL,
    person_id BLOB NOT NULL,
    examiner_id BLOB NOT NULL,
    begun_at INTEGER NOT NULL,
    answers TEXT NOT NULL, -- JSON, as in `ratings`; no texts
    finished_at INTEGER,
    UNIQUE (school_id, id),
    UNIQUE (school_id, exam_id, person_id),
    FOREIGN KEY (school_id, exam_id) REFERENCES exams (school_id, id),
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id),
    FOREIGN KEY (school_id, examiner_id) REFERENCES people (school_id, id)
) STRICT;

CREATE INDEX exam_sittings_by_person ON exam_sittings (school_id, person_id, begun_at);
CREATE INDEX exam_sittings_by_examiner ON exam_sittings (school_id, examiner_id);

CREATE TRIGGER exam_sittings_never_change BEFORE UPDATE ON exam_sittings
WHEN OLD.finished_at IS NOT NULL OR NEW.id <> OLD.id OR NEW.exam_id <> OLD.exam_id OR NEW.person_id <> OLD.person_id
    OR NEW.examiner_id <> OLD.examiner_id OR NEW.begun_at <> OLD.begun_at
BEGIN SELECT RAISE(ABORT, 'a sitting keeps its candidate, examiner and begin, and its answers once finished'); END;
CREATE TRIGGER exam_sittings_never_go BEFORE DELETE ON exam_sittings
BEGIN SELECT RAISE(ABORT, 'a sitting is never deleted'); END;
