-- Attempts, as uploaded, and what the server made of them. The client makes a session's id, so it is unique
-- within a school only: one school cannot learn of, or block, another's.
CREATE TABLE sessions (
    school_id BLOB NOT NULL REFERENCES schools (id),
    id BLOB NOT NULL CHECK (length(id) = 16),
    trainee_id BLOB NOT NULL,
    exercise_id TEXT NOT NULL,
    exercise_sha256 TEXT NOT NULL,
    scene_sha256 TEXT NOT NULL,
    revision_id BLOB, -- absent: the recording carries an exercise that this school never published
    started_at INTEGER NOT NULL,
    received_at INTEGER NOT NULL,
    duration_s REAL NOT NULL,
    complete INTEGER NOT NULL CHECK (complete IN (0, 1)), -- 0: the recording was cut
    device TEXT NOT NULL,
    simulator_version TEXT NOT NULL,
    seed TEXT NOT NULL, -- unsigned 64-bit, in decimal
    state TEXT NOT NULL CHECK (state IN ('pending', 'scored', 'refused')),
    refusal TEXT,
    recording_path TEXT NOT NULL, -- relative to the recordings folder
    recording_sha256 TEXT NOT NULL,
    recording_size INTEGER NOT NULL, -- bytes
    verify_deviation_n REAL, -- largest, of the server's re-simulation
    verify_event_differences INTEGER,
    verify_flagged INTEGER CHECK (verify_flagged IN (0, 1)),
    PRIMARY KEY (school_id, id),
    FOREIGN KEY (school_id, trainee_id) REFERENCES people (school_id, id),
    FOREIGN KEY (school_id, revision_id) REFERENCES exercise_revisions (school_id, id)
) STRICT;

CREATE INDEX sessions_by_trainee ON sessions (school_id, trainee_id, exercise_id, started_at);

CREATE TABLE metrics (
    school_id BLOB NOT NULL,
    session_id BLOB NOT NULL,
    id TEXT NOT NULL,
    version INTEGER NOT NULL,
    position INTEGER NOT NULL, -- in the catalogue's order
    value REAL, -- absent outside the metric's domain
    unit TEXT NOT NULL,
    direction TEXT NOT NULL CHECK (direction IN ('lower', 'higher', 'range')),
    applies INTEGER NOT NULL CHECK (applies IN (0, 1)),
    label TEXT NOT NULL,
    absent TEXT NOT NULL, -- why the metric does not apply; empty where it does
    PRIMARY KEY (school_id, session_id, id, version),
    FOREIGN KEY (school_id, session_id) REFERENCES sessions (school_id, id)
) STRICT;

-- One row per grading; a re-grading adds a row, the newest counts.
CREATE TABLE scores (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL,
    session_id BLOB NOT NULL,
    score REAL NOT NULL, -- 0–100
    passed INTEGER NOT NULL CHECK (passed IN (0, 1)),
    rubric_id TEXT NOT NULL,
    rubric_sha256 TEXT NOT NULL,
    deductions TEXT NOT NULL, -- JSON
    hard_fails TEXT NOT NULL, -- JSON
    simulator_version TEXT NOT NULL,
    computed_at INTEGER NOT NULL,
    FOREIGN KEY (school_id, session_id) REFERENCES sessions (school_id, id)
) STRICT;

CREATE INDEX scores_by_session ON scores (school_id, session_id, computed_at);

CREATE TRIGGER scores_never_change BEFORE UPDATE ON scores
BEGIN SELECT RAISE(ABORT, 'a score never changes: a re-grading adds a row'); END;
CREATE TRIGGER scores_never_go BEFORE DELETE ON scores
BEGIN SELECT RAISE(ABORT, 'a score is never deleted'); END;

-- What a page draws, decimated once when the recording is scored.
CREATE TABLE session_curves (
    school_id BLOB NOT NULL,
    session_id BLOB NOT NULL,
    body TEXT NOT NULL, -- JSON
    PRIMARY KEY (school_id, session_id),
    FOREIGN KEY (school_id, session_id) REFERENCES sessions (school_id, id)
) STRICT;
