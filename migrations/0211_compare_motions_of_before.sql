-- Attempts of before there was a hash of motions: the worker reads their recordings when nothing else waits.
CREATE TABLE unhashed_motions (
    school_id BLOB NOT NULL,
    session_id BLOB NOT NULL,
    PRIMARY KEY (school_id, session_id),
    FOREIGN KEY (school_id, session_id) REFERENCES sessions (school_id, id) ON DELETE CASCADE
) STRICT;

-- In the order in which they came.
INSERT INTO unhashed_motions (school_id, session_id)
SELECT school_id, id FROM sessions WHERE motion_sha256 IS NULL ORDER BY rowid;
