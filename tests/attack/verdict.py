"""What an attack comes to, and how it says so."""


class GotThrough(Exception):
    """The service let it happen."""


class NotTried(Exception):
    """The honest counterpart failed: a refusal would mean nothing."""


def honest(holds, what):
    """The positive control: what an honest person does must succeed, or the attack shows nothing."""
    if not holds:
        raise NotTried(f"control: {what}")


def refuse(holds, what):
    """The service must have refused."""
    if not holds:
        raise GotThrough(str(what))


def status(answer, *allowed):
    """An answer's status must be one of these; what it was."""
    refuse(answer.status in allowed, f"answered {answer}; refused is {' or '.join(map(str, allowed))}")
    return answer.status


def lets_through_today(reason):
    """Marks an attack that is known to get through: it is tried and shown, and does not fail the run."""

    def mark(attack):
        attack.known = reason
        return attack

    return mark


def alone(attack):
    """Marks an attack that wants the machine to itself, for it measures times."""
    attack.alone = True
    return attack
