-- What an attempt proves. One counts where its exercise is a revision that the school published and nobody has brought the
-- same motion before; every other is kept, shown as what it is, and counts nowhere.
ALTER TABLE sessions ADD COLUMN uncounted TEXT CHECK (uncounted IN ('unpublished', 'duplicate')); -- NULL: it counts
ALTER TABLE sessions ADD COLUMN motion_sha256 TEXT; -- of the samples' inputs; NULL without samples, and for recordings of before
ALTER TABLE sessions ADD COLUMN repeats BLOB; -- the attempt whose motion this one repeats
ALTER TABLE sessions ADD COLUMN claimed_started_at INTEGER; -- what the recording says, where started_at is not that
ALTER TABLE sessions ADD COLUMN signed_by BLOB; -- the paired station whose signature was right when it was received
CREATE UNIQUE INDEX sessions_by_motion ON sessions (school_id, motion_sha256)
    WHERE motion_sha256 IS NOT NULL AND uncounted IS NULL;
CREATE INDEX sessions_uncounted ON sessions (school_id) WHERE uncounted IS NOT NULL;

-- The sender's clock minus ours, in µs, where it was told when the upload began.
ALTER TABLE uploads ADD COLUMN clock_offset_us INTEGER;

-- A station's Ed25519 public key, 64 hexadecimal digits; NULL for stations that were paired before there were any.
ALTER TABLE api_tokens ADD COLUMN public_key TEXT;

-- What must be proved of an attempt for it to count towards a certificate.
ALTER TABLE schools ADD COLUMN certificate_needs TEXT NOT NULL DEFAULT 'signed_or_supervised'
    CHECK (certificate_needs IN ('nothing', 'resimulated', 'signed_or_supervised', 'supervised'));

-- What is proved of an attempt. A signature holds for what the hand did; that the rest follows from it, the re-simulation shows.
CREATE VIEW proofs AS
SELECT s.school_id, s.id AS session_id, s.trainee_id,
    coalesce(s.signed_by IS NOT NULL AND s.verify_flagged = 0, 0) AS signed,
    coalesce(s.verify_flagged = 0, 0) AS resimulated,
    EXISTS (SELECT 1 FROM supervisions v WHERE v.school_id = s.school_id AND v.session_id = s.id) AS supervised
FROM sessions s;

UPDATE sessions SET uncounted = 'unpublished'
WHERE revision_id IS NULL OR NOT EXISTS (
    SELECT 1 FROM exercise_revisions r WHERE r.id = sessions.revision_id AND r.exercise_id = sessions.exercise_id);

-- What claims to have ended after it was received began when it can have begun at the latest.
UPDATE sessions SET claimed_started_at = started_at, started_at = received_at - CAST(duration_s * 1000000 AS INTEGER)
WHERE started_at > received_at - CAST(duration_s * 1000000 AS INTEGER);

-- The sums again, of the schools that have such attempts; otherwise as they were first made.
CREATE TEMP TABLE again AS SELECT DISTINCT school_id FROM sessions
WHERE uncounted IS NOT NULL OR claimed_started_at IS NOT NULL;
CREATE TEMP TABLE counted AS
SELECT s.school_id, s.trainee_id, s.exercise_id, s.id, s.started_at, s.revision_id, g.score, g.passed
FROM again CROSS JOIN sessions s ON s.school_id = again.school_id AND s.state = 'scored' AND s.uncounted IS NULL
JOIN grades g ON g.school_id = s.school_id AND g.session_id = s.id
ORDER BY s.started_at, s.id;

DELETE FROM practice WHERE school_id IN (SELECT school_id FROM again);
INSERT INTO practice (school_id, trainee_id, exercise_id, attempts, passes, points, history)
SELECT school_id, trainee_id, exercise_id, count(*), sum(passed), sum(score),
    json_group_array(json_array(lower(hex(id)), started_at, score, json(iif(passed, 'true', 'false')),
        lower(hex(revision_id))) ORDER BY started_at, id)
FROM counted GROUP BY school_id, trainee_id, exercise_id;

DELETE FROM tallies WHERE school_id IN (SELECT school_id FROM again);
INSERT INTO tallies (school_id, cohort_id, month, attempts, passes, points)
SELECT school_id, cohort_id, month, count(*), sum(passed), sum(score)
FROM (SELECT c.school_id, m.cohort_id, c.passed, c.score,
        12 * CAST(strftime('%Y', c.started_at / 1000000, 'unixepoch') AS INTEGER)
        + CAST(strftime('%m', c.started_at / 1000000, 'unixepoch') AS INTEGER) - 1 AS month
      FROM counted c
      JOIN (SELECT person_id, cohort_id FROM cohort_members WHERE role = 'trainee'
            UNION ALL SELECT id, zeroblob(16) FROM people) m ON m.person_id = c.trainee_id)
GROUP BY school_id, cohort_id, month;

DROP TABLE counted;
DROP TABLE again;
