-- What people say about a score. The computed ones stay as they are, and so does every override: the newest counts,
-- and one without a score says that the computed score counts again.
CREATE TABLE score_overrides (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL,
    session_id BLOB NOT NULL,
    score REAL CHECK (score BETWEEN 0 AND 100), -- 0–100
    passed INTEGER CHECK (passed IN (0, 1)),
    reason TEXT NOT NULL CHECK (length(trim(reason)) > 0),
    made_by BLOB NOT NULL,
    made_at INTEGER NOT NULL,
    CHECK ((score IS NULL) = (passed IS NULL)),
    FOREIGN KEY (school_id, session_id) REFERENCES sessions (school_id, id),
    FOREIGN KEY (school_id, made_by) REFERENCES people (school_id, id)
) STRICT;

CREATE INDEX score_overrides_by_session ON score_overrides (school_id, session_id, made_at, id);

CREATE TRIGGER score_overrides_never_change BEFORE UPDATE ON score_overrides
BEGIN SELECT RAISE(ABORT, 'an override never changes: another one is added'); END;
CREATE TRIGGER score_overrides_never_go BEFORE DELETE ON score_overrides
BEGIN SELECT RAISE(ABORT, 'an override is never deleted'); END;

-- The grade that counts, one row per scored attempt: every page, export and rule reads it here. Triggers keep it, so
-- that no writer of scores can forget it.
CREATE TABLE grades (
    school_id BLOB NOT NULL,
    session_id BLOB NOT NULL,
    score_id BLOB NOT NULL REFERENCES scores (id), -- the newest computed score
    override_id BLOB REFERENCES score_overrides (id), -- the override that counts in its place
    score REAL NOT NULL, -- 0–100
    passed INTEGER NOT NULL CHECK (passed IN (0, 1)),
    PRIMARY KEY (school_id, session_id),
    FOREIGN KEY (school_id, session_id) REFERENCES sessions (school_id, id)
) STRICT, WITHOUT ROWID;

INSERT INTO grades (school_id, session_id, score_id, score, passed)
SELECT c.school_id, c.session_id, c.id, c.score, c.passed FROM scores c
WHERE c.id = (SELECT n.id FROM scores n WHERE n.school_id = c.school_id AND n.session_id = c.session_id
              ORDER BY n.computed_at DESC, n.id DESC LIMIT 1);

CREATE TRIGGER grades_follow_scores AFTER INSERT ON scores
BEGIN
    INSERT INTO grades (school_id, session_id, score_id, score, passed)
    VALUES (NEW.school_id, NEW.session_id, NEW.id, NEW.score, NEW.passed)
    ON CONFLICT (school_id, session_id) DO UPDATE SET
        score_id = excluded.score_id,
        score = CASE WHEN grades.override_id IS NULL THEN excluded.score ELSE grades.score END,
        passed = CASE WHEN grades.override_id IS NULL THEN excluded.passed ELSE grades.passed END;
END;

CREATE TRIGGER grades_follow_overrides AFTER INSERT ON score_overrides
BEGIN
    UPDATE grades SET
        override_id = CASE WHEN NEW.score IS NULL THEN NULL ELSE NEW.id END,
        score = coalesce(NEW.score, (SELECT c.score FROM scores c WHERE c.id = grades.score_id)),
        passed = coalesce(NEW.passed, (SELECT c.passed FROM scores c WHERE c.id = grades.score_id))
    WHERE school_id = NEW.school_id AND session_id = NEW.session_id;
END;

-- Attempts that somebody has looked at. Taking the mark back deletes the row; the audit log keeps both acts.
CREATE TABLE reviews (
    school_id BLOB NOT NULL,
    session_id BLOB NOT NULL,
    reviewed_by BLOB NOT NULL,
    reviewed_at INTEGER NOT NULL,
    PRIMARY KEY (school_id, session_id),
    FOREIGN KEY (school_id, session_id) REFERENCES sessions (school_id, id),
    FOREIGN KEY (school_id, reviewed_by) REFERENCES people (school_id, id)
) STRICT;

-- The mark once more where the queue looks for it: an index over the attempts that wait stays as small as the queue.
ALTER TABLE sessions ADD COLUMN reviewed INTEGER NOT NULL DEFAULT 0 CHECK (reviewed IN (0, 1));
CREATE TRIGGER sessions_follow_reviews AFTER INSERT ON reviews
BEGIN UPDATE sessions SET reviewed = 1 WHERE school_id = NEW.school_id AND id = NEW.session_id; END;
CREATE TRIGGER sessions_follow_withdrawn_reviews AFTER DELETE ON reviews
BEGIN UPDATE sessions SET reviewed = 0 WHERE school_id = OLD.school_id AND id = OLD.session_id; END;

CREATE INDEX sessions_to_review ON sessions (school_id, verify_flagged DESC, started_at, id)
WHERE state = 'scored' AND reviewed = 0;
CREATE INDEX sessions_to_review_by_trainee ON sessions (school_id, trainee_id, started_at)
WHERE state = 'scored' AND reviewed = 0;
