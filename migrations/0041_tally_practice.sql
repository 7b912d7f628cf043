-- What pages of many attempts read, so that none of them loads a row per attempt. Kept in the transaction that scores,
-- re-grades or overrides; everything in it can be made again from sessions and scores.
CREATE TABLE practice (
    school_id BLOB NOT NULL,
    trainee_id BLOB NOT NULL,
    exercise_id TEXT NOT NULL,
    attempts INTEGER NOT NULL, -- scored ones
    passes INTEGER NOT NULL,
    points REAL NOT NULL, -- sum of the scores
    history TEXT NOT NULL, -- JSON: [[session, started µs, score, passed, revision], …]
    PRIMARY KEY (school_id, trainee_id, exercise_id),
    FOREIGN KEY (school_id, trainee_id) REFERENCES people (school_id, id)
) STRICT;

-- Sums by month of the attempts: of a cohort, or of the whole school where cohort_id is 16 zeros.
CREATE TABLE tallies (
    school_id BLOB NOT NULL REFERENCES schools (id),
    cohort_id BLOB NOT NULL CHECK (length(cohort_id) = 16),
    month INTEGER NOT NULL, -- 12 × year + month − 1, UTC
    attempts INTEGER NOT NULL,
    passes INTEGER NOT NULL,
    points REAL NOT NULL,
    PRIMARY KEY (school_id, cohort_id, month)
) STRICT;

CREATE TEMP TABLE scored AS
SELECT s.school_id, s.trainee_id, s.exercise_id, s.id, s.started_at, s.revision_id, c.score, c.passed
FROM sessions s
JOIN scores c ON c.id = (SELECT n.id FROM scores n WHERE n.school_id = s.school_id AND n.session_id = s.id
                         ORDER BY n.computed_at DESC, n.id DESC LIMIT 1)
WHERE s.state = 'scored';

INSERT INTO practice (school_id, trainee_id, exercise_id, attempts, passes, points, history)
SELECT school_id, trainee_id, exercise_id, count(*), sum(passed), sum(score),
    json_group_array(json_array(lower(hex(id)), started_at, score, json(iif(passed, 'true', 'false')),
        CASE WHEN revision_id IS NULL THEN NULL ELSE lower(hex(revision_id)) END))
FROM scored GROUP BY school_id, trainee_id, exercise_id;

INSERT INTO tallies (school_id, cohort_id, month, attempts, passes, points)
SELECT school_id, zeroblob(16), month, count(*), sum(passed), sum(score)
FROM (SELECT school_id, passed, score, 12 * CAST(strftime('%Y', started_at / 1000000, 'unixepoch') AS INTEGER)
        + CAST(strftime('%m', started_at / 1000000, 'unixepoch') AS INTEGER) - 1 AS month FROM scored)
GROUP BY school_id, month;

INSERT INTO tallies (school_id, cohort_id, month, attempts, passes, points)
SELECT school_id, cohort_id, month, count(*), sum(passed), sum(score)
FROM (SELECT s.school_id, m.cohort_id, s.passed, s.score,
        12 * CAST(strftime('%Y', s.started_at / 1000000, 'unixepoch') AS INTEGER)
        + CAST(strftime('%m', s.started_at / 1000000, 'unixepoch') AS INTEGER) - 1 AS month
      FROM scored s JOIN cohort_members m ON m.person_id = s.trainee_id AND m.role = 'trainee')
GROUP BY school_id, cohort_id, month;

DROP TABLE scored;
