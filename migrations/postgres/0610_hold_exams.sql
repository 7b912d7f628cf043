-- Exams at one station: an examiner rates each candidate of a cohort with an instrument, within a time limit; a second
-- rater rates the recorded attempts in a blinded round.
CREATE TABLE exams (
    id UUID PRIMARY KEY NOT NULL,
    school_id UUID NOT NULL REFERENCES schools (id),
    title TEXT COLLATE "C" NOT NULL CHECK (length(trim(title)) > 0),
    cohort_id UUID NOT NULL,
    exercise_id TEXT COLLATE "C" NOT NULL,
    revision_id UUID NOT NULL, -- of the instrument
    limit_min BIGINT NOT NULL CHECK (limit_min BETWEEN 1 AND 120),
    second_rater_id UUID, -- absent: each candidate is rated once
    round_id UUID, -- of the second ratings; absent: none were requested
    made_by UUID NOT NULL,
    made_at BIGINT NOT NULL,
    closed_at BIGINT,
    UNIQUE (school_id, id),
    FOREIGN KEY (school_id, cohort_id) REFERENCES cohorts (school_id, id),
    FOREIGN KEY (school_id, exercise_id) REFERENCES exercises (school_id, exercise_id),
    FOREIGN KEY (school_id, revision_id) REFERENCES instrument_revisions (school_id, id),
    FOREIGN KEY (school_id, second_rater_id) REFERENCES people (school_id, id),
    FOREIGN KEY (school_id, round_id) REFERENCES rating_rounds (school_id, id),
    FOREIGN KEY (school_id, made_by) REFERENCES people (school_id, id)
);

CREATE INDEX exams_by_time ON exams (school_id, made_at);
CREATE INDEX exams_by_maker ON exams (school_id, made_by);
CREATE INDEX exams_by_second_rater ON exams (school_id, second_rater_id);
CREATE INDEX exams_by_round ON exams (round_id) WHERE round_id IS NOT NULL;

-- One candidate at the station. The examiner and the times are those of the service.
CREATE TABLE exam_sittings (
    id UUID PRIMARY KEY NOT NULL,
    school_id UUID NOT NULL,
    exam_id UUID NOT NULL,
    person_id UUID NOT NULL,
    examiner_id UUID NOT NULL,
    begun_at BIGINT NOT NULL,
    answers TEXT COLLATE "C" NOT NULL, -- JSON, as in `ratings`; no texts
    finished_at BIGINT,
    UNIQUE (school_id, id),
    UNIQUE (school_id, exam_id, person_id),
    FOREIGN KEY (school_id, exam_id) REFERENCES exams (school_id, id),
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id),
    FOREIGN KEY (school_id, examiner_id) REFERENCES people (school_id, id)
);

CREATE INDEX exam_sittings_by_person ON exam_sittings (school_id, person_id, begun_at);
CREATE INDEX exam_sittings_by_examiner ON exam_sittings (school_id, examiner_id);

CREATE TRIGGER exam_sittings_never_change BEFORE UPDATE ON exam_sittings
FOR EACH ROW WHEN (OLD.finished_at IS NOT NULL OR NEW.id <> OLD.id OR NEW.exam_id <> OLD.exam_id OR NEW.person_id <> OLD.person_id
    OR NEW.examiner_id <> OLD.examiner_id OR NEW.begun_at <> OLD.begun_at)
EXECUTE FUNCTION refuse('a sitting keeps its candidate, examiner and begin, and its answers once finished');
CREATE TRIGGER exam_sittings_never_go BEFORE DELETE ON exam_sittings
FOR EACH ROW EXECUTE FUNCTION refuse('a sitting is never deleted');
CREATE TRIGGER exam_sittings_never_go_all_at_once BEFORE TRUNCATE ON exam_sittings
EXECUTE FUNCTION refuse('a sitting is never deleted');
