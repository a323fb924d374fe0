"""Results as pandas tables and, in notebooks, as HTML."""

from typing import Any

_SHOWN = 10  # rows of a long table in a notebook


def frame(columns: dict[str, Any]) -> Any:
    """Return columns as a pandas `DataFrame`.

    Raises
    ------
    ImportError
        If pandas is not installed.
    """
    try:
        from pandas import DataFrame
    except ImportError:
        raise ImportError("to_frame needs pandas; run: pip install pandas") from None
    return DataFrame(columns)


def html(table: Any, caption: str = "") -> str | None:
    """Return the first and last rows for a notebook; None without pandas."""
    from html import escape

    try:
        shown = table.to_frame().to_html(max_rows=_SHOWN, index=False)
    except ImportError:
        return None
    return f"<p><code>{escape(caption or repr(table))}</code></p>{shown}"
