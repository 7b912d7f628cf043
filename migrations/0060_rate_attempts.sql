-- Several raters judge the same attempts with one revision of an instrument, each for themselves.
CREATE TABLE rating_rounds (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL,
    revision_id BLOB NOT NULL,
    title TEXT NOT NULL CHECK (length(trim(title)) > 0),
    generated INTEGER NOT NULL CHECK (generated IN (0, 1)), -- the ratings were made by a program
    made_by BLOB NOT NULL,
    made_at INTEGER NOT NULL,
    withdrawn_at INTEGER,
    UNIQUE (school_id, id),
    FOREIGN KEY (school_id, revision_id) REFERENCES instrument_revisions (school_id, id),
    FOREIGN KEY (school_id, made_by) REFERENCES people (school_id, id)
) STRICT;

CREATE INDEX rating_rounds_by_school ON rating_rounds (school_id, made_at);
CREATE INDEX rating_rounds_by_maker ON rating_rounds (school_id, made_by, made_at);

-- One row for each rater and attempt, made with the round. Its id is random: a rater knows an attempt by it alone, and
-- sees the attempts in its order, another for each.
CREATE TABLE ratings (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL,
    round_id BLOB NOT NULL,
    session_id BLOB NOT NULL,
    rater_id BLOB NOT NULL,
    answers TEXT NOT NULL, -- JSON: an array in the order of the instrument's items
    finished_at INTEGER,
    UNIQUE (round_id, session_id, rater_id),
    FOREIGN KEY (school_id, round_id) REFERENCES rating_rounds (school_id, id),
    FOREIGN KEY (school_id, session_id) REFERENCES sessions (school_id, id),
    FOREIGN KEY (school_id, rater_id) REFERENCES people (school_id, id)
) STRICT;

CREATE INDEX ratings_by_rater ON ratings (school_id, rater_id, round_id);
CREATE INDEX ratings_by_session ON ratings (school_id, session_id);

CREATE TRIGGER finished_ratings_never_change BEFORE UPDATE ON ratings WHEN OLD.finished_at IS NOT NULL
BEGIN SELECT RAISE(ABORT, 'a finished rating never changes'); END;
CREATE TRIGGER ratings_never_go BEFORE DELETE ON ratings
BEGIN SELECT RAISE(ABORT, 'a rating is never deleted: the round is taken back'); END;

-- Who can be asked to rate.
CREATE INDEX people_who_teach ON people (school_id, display_name) WHERE role = 'instructor';
