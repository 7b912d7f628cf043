-- Every attempt at an exercise graded again by the rubric of one of its revisions: looked at first, then done as it was shown.
CREATE TABLE regradings (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL,
    exercise_id TEXT NOT NULL,
    revision_id BLOB NOT NULL, -- whose rubric judges
    state TEXT NOT NULL CHECK (state IN ('looking', 'shown', 'grading', 'done')),
    reason TEXT CHECK (length(trim(reason)) > 0),
    made_by BLOB NOT NULL,
    made_at INTEGER NOT NULL,
    confirmed_at INTEGER,
    ended_at INTEGER,
    UNIQUE (school_id, id),
    FOREIGN KEY (school_id, exercise_id) REFERENCES exercises (school_id, exercise_id),
    FOREIGN KEY (school_id, revision_id) REFERENCES exercise_revisions (school_id, id),
    FOREIGN KEY (school_id, made_by) REFERENCES people (school_id, id),
    CHECK ((state IN ('grading', 'done')) = (reason IS NOT NULL)),
    CHECK ((reason IS NULL) = (confirmed_at IS NULL))
) STRICT;

CREATE INDEX regradings_by_exercise ON regradings (school_id, exercise_id, made_at);
CREATE INDEX regradings_under_way ON regradings (made_at) WHERE state IN ('looking', 'grading');

-- An attempt as it stood when it was looked at, and what it would score.
CREATE TABLE regrading_lines (
    school_id BLOB NOT NULL,
    regrading_id BLOB NOT NULL,
    session_id BLOB NOT NULL,
    score_id BLOB NOT NULL REFERENCES scores (id), -- the newest computed score
    override_id BLOB REFERENCES score_overrides (id), -- what counts in its place
    before REAL NOT NULL, -- the computed score, 0–100
    passed_before INTEGER NOT NULL CHECK (passed_before IN (0, 1)),
    after REAL, -- 0–100
    passed_after INTEGER CHECK (passed_after IN (0, 1)),
    outcome TEXT CHECK (outcome IN ('passes', 'fails', 'changed', 'overridden', 'equal', 'same', 'unreadable', 'overtaken')), -- absent: not looked at yet
    why TEXT, -- it cannot be read
    assessment TEXT, -- JSON, until it has become a score
    new_score_id BLOB REFERENCES scores (id),
    PRIMARY KEY (school_id, regrading_id, session_id),
    FOREIGN KEY (school_id, regrading_id) REFERENCES regradings (school_id, id),
    FOREIGN KEY (school_id, session_id) REFERENCES sessions (school_id, id)
) STRICT, WITHOUT ROWID;

CREATE INDEX regrading_lines_by_outcome ON regrading_lines (regrading_id, outcome, session_id);
CREATE INDEX regrading_lines_to_grade ON regrading_lines (regrading_id, session_id) WHERE assessment IS NOT NULL;
-- The history of a grade.
CREATE INDEX regrading_lines_by_session ON regrading_lines (school_id, session_id) WHERE new_score_id IS NOT NULL;
