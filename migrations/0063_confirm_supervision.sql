-- Somebody who teaches says that they were there during an attempt. Taking it back deletes the row; the audit log keeps
-- both acts.
CREATE TABLE supervisions (
    school_id BLOB NOT NULL,
    session_id BLOB NOT NULL,
    trainee_id BLOB NOT NULL, -- of the attempt
    confirmed_by BLOB NOT NULL,
    confirmed_at INTEGER NOT NULL,
    PRIMARY KEY (school_id, session_id),
    FOREIGN KEY (school_id, session_id) REFERENCES sessions (school_id, id),
    FOREIGN KEY (school_id, trainee_id) REFERENCES people (school_id, id),
    FOREIGN KEY (school_id, confirmed_by) REFERENCES people (school_id, id)
) STRICT;

CREATE INDEX supervisions_by_trainee ON supervisions (school_id, trainee_id);
