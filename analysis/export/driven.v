(* ---- From rest: 0 up to t = 0, a polynomial up to t = 1, then a harmonic oscillation ---- *)

Fixpoint poly (p : list R) (t : R) : R := match p with c :: q => c + t * poly q t | [] => 0 end.
Fixpoint dpoly (p : list R) (t : R) : R := match p with _ :: q => poly q t + t * dpoly q t | [] => 0 end.
Definition glued (f g : R -> R) (c t : R) : R := if Rle_dec t c then f t else g t.
Definition wave (p : list R) (a b om : R) : R -> R :=
  glued (fun _ => 0) (glued (poly p) (fun t => a * cos (om * (t - 1)) + b * sin (om * (t - 1))) 1) 0.

Lemma poly_flow : forall p t, derivable_pt_lim (poly p) t (dpoly p t).
Proof.
  induction p as [|c q IH]; intro t; cbn [dpoly]; [apply derivable_pt_lim_const|].
  apply (derivable_same (fun s => c + s * poly q s) _ t (0 + (1 * poly q t + t * dpoly q t))); [reflexivity|ring|].
  apply (derivable_pt_lim_plus (fun _ => c) (fun s => s * poly q s)); [apply derivable_pt_lim_const|].
  apply (derivable_pt_lim_mult (fun s => s) (poly q)); [apply derivable_pt_lim_id|apply IH].
Qed.
Lemma glued_flow : forall f g c t l, f c = g c -> (t <= c -> derivable_pt_lim f t l) ->
  (c <= t -> derivable_pt_lim g t l) -> derivable_pt_lim (glued f g c) t l.
Proof.
  intros f g c t l same F G eps epos; unfold glued.
  assert (near : forall d : posreal, 0 < Rmin d (if Req_EM_T t c then 1 else Rabs (t - c))).
  { intro d; apply Rmin_pos; [apply cond_pos|]; destruct (Req_EM_T t c); [lra|apply Rabs_pos_lt; lra]. }
  destruct (Rtotal_order t c) as [L|[->|L]].
  - destruct (F ltac:(lra) eps epos) as [d D]; exists (mkposreal _ (near d)); cbn; intros h h0 H.
    pose proof (Rmin_l d (if Req_EM_T t c then 1 else Rabs (t - c))).
    pose proof (Rmin_r d (if Req_EM_T t c then 1 else Rabs (t - c))).
    destruct (Req_EM_T t c); [lra|]; rewrite (Rabs_left (t - c)) in * by lra.
    pose proof (Rle_abs h); destruct (Rle_dec (t + h) c), (Rle_dec t c); try lra; apply D; lra.
  - destruct (F ltac:(lra) eps epos) as [d D], (G ltac:(lra) eps epos) as [e E].
    exists (mkposreal (Rmin d e) (Rmin_pos d e (cond_pos d) (cond_pos e))); cbn; intros h h0 H.
    pose proof (Rmin_l d e); pose proof (Rmin_r d e).
    destruct (Rle_dec c c) as [_|N]; [|lra]; destruct (Rle_dec (c + h) c); [apply D; lra|].
    rewrite same; apply E; lra.
  - destruct (G ltac:(lra) eps epos) as [d D]; exists (mkposreal _ (near d)); cbn; intros h h0 H.
    pose proof (Rmin_l d (if Req_EM_T t c then 1 else Rabs (t - c))).
    pose proof (Rmin_r d (if Req_EM_T t c then 1 else Rabs (t - c))).
    destruct (Req_EM_T t c); [lra|]; rewrite (Rabs_right (t - c)) in * by lra.
    pose proof (Rle_abs (- h)); rewrite Rabs_Ropp in *.
    destruct (Rle_dec (t + h) c), (Rle_dec t c); try lra; apply D; lra.
Qed.
Lemma turn_flow : forall om t, derivable_pt_lim (fun s => om * (s - 1)) t om.
Proof.
  intros om t; apply (derivable_same (fun s => om * (s - 1)) _ t (om * (1 - 0))); [reflexivity|ring|].
  apply (derivable_pt_lim_scal (fun s => s - 1)), (derivable_pt_lim_minus (fun s => s) (fun _ => 1));
    [apply derivable_pt_lim_id|apply derivable_pt_lim_const].
Qed.
Lemma cos_flow : forall om t, derivable_pt_lim (fun s => cos (om * (s - 1))) t (- om * sin (om * (t - 1))).
Proof.
  intros om t; eapply derivable_same; [reflexivity| |apply (derivable_pt_lim_comp _ cos); [apply turn_flow|]].
  2: apply derivable_pt_lim_cos.
  cbv beta; ring.
Qed.
Lemma sin_flow : forall om t, derivable_pt_lim (fun s => sin (om * (s - 1))) t (om * cos (om * (t - 1))).
Proof.
  intros om t; eapply derivable_same; [reflexivity| |apply (derivable_pt_lim_comp _ sin); [apply turn_flow|]].
  2: apply derivable_pt_lim_sin.
  cbv beta; ring.
Qed.
Lemma at_one : forall om, cos (om * (1 - 1)) = 1 /\ sin (om * (1 - 1)) = 0.
Proof. intro om; replace (om * (1 - 1)) with 0 by ring; split; [apply cos_0|apply sin_0]. Qed.

Lemma wave_flow : forall p p' a b a' b' om, (forall s, dpoly p s = poly p' s) -> a' = om * b -> b' = - (om * a) ->
  poly p 0 = 0 -> poly p' 0 = 0 -> poly p 1 = a -> poly p' 1 = a' ->
  forall t, derivable_pt_lim (wave p a b om) t (wave p' a' b' om t).
Proof.
  intros p p' a b a' b' om D A B p0 p0' p1 p1' t; unfold wave.
  destruct (at_one om) as [c1 s1].
  apply glued_flow.
  - unfold glued; destruct (Rle_dec 0 1); [now rewrite p0|lra].
  - intro L; unfold glued; destruct (Rle_dec t 0); [apply derivable_pt_lim_const|lra].
  - intro L; apply glued_flow.
    + rewrite c1, s1, p1; ring.
    + intro M; eapply derivable_same; [reflexivity| |apply poly_flow]; rewrite D; unfold glued.
      destruct (Rle_dec t 0); [replace t with 0 by lra; exact p0'|]; destruct (Rle_dec t 1); [reflexivity|lra].
    + intro M; apply (derivable_same (fun s => a * cos (om * (s - 1)) + b * sin (om * (s - 1))) _ t
        (a * (- om * sin (om * (t - 1))) + b * (om * cos (om * (t - 1))))); [reflexivity| |].
      * unfold glued; destruct (Rle_dec t 0); [lra|]; destruct (Rle_dec t 1); [|subst; ring].
        assert (t = 1) as -> by lra; rewrite c1, s1, p1', A; ring.
      * apply (derivable_pt_lim_plus (fun s => a * cos (om * (s - 1))) (fun s => b * sin (om * (s - 1)))).
        -- apply (derivable_pt_lim_scal (fun s => cos (om * (s - 1)))), cos_flow.
        -- apply (derivable_pt_lim_scal (fun s => sin (om * (s - 1)))), sin_flow.
Qed.

(* The integral of its square. *)
Definition energy (P : list R) (A al be om : R) : R -> R :=
  glued (fun _ => 0) (glued (poly P) (fun t => poly P 1 + A * (t - 1)
    + (al * (cos (om * (t - 1)) * sin (om * (t - 1))) + be * (sin (om * (t - 1)) * sin (om * (t - 1))))) 1) 0.
Lemma energy_flow : forall P p a b A al be om, (forall s, dpoly P s = poly p s ^ 2) -> poly P 0 = 0 ->
  poly p 0 = 0 -> poly p 1 = a -> (om = 0 \/ A - al * om = b ^ 2) -> A + al * om = a ^ 2 -> be * om = a * b ->
  forall t, derivable_pt_lim (energy P A al be om) t (wave p a b om t ^ 2).
Proof.
  intros P p a b A al be om D P0 p0 p1 H1 H2 H3 t; unfold energy, wave.
  destruct (at_one om) as [c1 s1].
  apply glued_flow.
  - unfold glued; destruct (Rle_dec 0 1); [now rewrite P0|lra].
  - intro L; unfold glued; destruct (Rle_dec t 0); [|lra].
    eapply derivable_same; [reflexivity| |apply derivable_pt_lim_const]; ring.
  - intro L; apply glued_flow.
    + rewrite c1, s1; ring.
    + intro M; eapply derivable_same; [reflexivity| |apply poly_flow]; rewrite D; unfold glued.
      destruct (Rle_dec t 0); [replace t with 0 by lra; rewrite p0; ring|]; destruct (Rle_dec t 1); [reflexivity|lra].
    + intro M; set (c := cos (om * (t - 1))); set (s := sin (om * (t - 1))).
      assert (E : derivable_pt_lim (fun t => poly P 1 + A * (t - 1) + (al * (cos (om * (t - 1)) * sin (om * (t - 1)))
        + be * (sin (om * (t - 1)) * sin (om * (t - 1))))) t
        (0 + A * (1 - 0) + (al * (- om * s * s + c * (om * c)) + be * (om * c * s + s * (om * c))))).
      { apply (derivable_pt_lim_plus (fun t => poly P 1 + A * (t - 1)) (fun t => al * (cos (om * (t - 1))
          * sin (om * (t - 1))) + be * (sin (om * (t - 1)) * sin (om * (t - 1))))).
        - apply (derivable_pt_lim_plus (fun _ => poly P 1) (fun t => A * (t - 1))); [apply derivable_pt_lim_const|].
          apply (derivable_pt_lim_scal (fun t => t - 1)), (derivable_pt_lim_minus (fun t => t) (fun _ => 1));
            [apply derivable_pt_lim_id|apply derivable_pt_lim_const].
        - apply (derivable_pt_lim_plus (fun t => al * (cos (om * (t - 1)) * sin (om * (t - 1))))
            (fun t => be * (sin (om * (t - 1)) * sin (om * (t - 1))))).
          + apply (derivable_pt_lim_scal (fun t => cos (om * (t - 1)) * sin (om * (t - 1)))).
            apply (derivable_pt_lim_mult (fun t => cos (om * (t - 1))) (fun t => sin (om * (t - 1))));
              [apply cos_flow|apply sin_flow].
          + apply (derivable_pt_lim_scal (fun t => sin (om * (t - 1)) * sin (om * (t - 1)))).
            apply (derivable_pt_lim_mult (fun t => sin (om * (t - 1))) (fun t => sin (om * (t - 1)))); apply sin_flow. }
      eapply derivable_same; [reflexivity| |exact E].
      assert (S1 : s * s + c * c = 1) by (pose proof (sin2_cos2 (om * (t - 1))) as Q; unfold Rsqr in Q; exact Q).
      assert (W : 0 + A * (1 - 0) + (al * (- om * s * s + c * (om * c)) + be * (om * c * s + s * (om * c)))
        = (a * c + b * s) ^ 2).
      { destruct H1 as [Z|H1].
        - assert (s = 0) as S0 by (unfold s; rewrite Z; replace (0 * (t - 1)) with 0 by ring; apply sin_0).
          assert (c = 1) as C0 by (unfold c; rewrite Z; replace (0 * (t - 1)) with 0 by ring; apply cos_0).
          rewrite S0, C0; rewrite <- (Rmult_1_r A) in H2; nra.
        - replace (A * (1 - 0)) with (A * (s * s + c * c)) by (rewrite S1; ring).
          replace (0 + A * (s * s + c * c) + (al * (- om * s * s + c * (om * c)) + be * (om * c * s + s * (om * c))))
            with ((A + al * om) * (c * c) + (A - al * om) * (s * s) + 2 * (be * om) * (c * s)) by ring.
          rewrite H1, H2, H3; ring. }
      rewrite W; unfold glued; destruct (Rle_dec t 0); [lra|]; destruct (Rle_dec t 1); [|reflexivity].
      assert (t = 1) by lra; unfold c, s; subst t; rewrite c1, s1, p1; ring.
Qed.
Lemma energy_late : forall P A al be om t, 1 < t -> sin (om * (t - 1)) = 0 ->
  energy P A al be om t = poly P 1 + A * (t - 1).
Proof.
  intros P A al be om t T S; unfold energy, glued.
  destruct (Rle_dec t 0); [lra|]; destruct (Rle_dec t 1); [lra|]; rewrite S; ring.
Qed.
Lemma energy_start : forall P A al be om, energy P A al be om 0 = 0.
Proof. intros; unfold energy, glued; destruct (Rle_dec 0 0); [reflexivity|lra]. Qed.

(* The times at which the sine is 0 have no end. *)
Lemma late : forall om K M, 0 <= om -> 0 < M -> exists t, 1 < t /\ sin (om * (t - 1)) = 0 /\ 0 < K + M * (t - 1).
Proof.
  intros om K M [pos|<-] Mpos.
  - assert (step : 0 < 2 * PI / om) by (apply Rdiv_lt_0_compat; [pose proof PI_RGT_0; lra|exact pos]).
    destruct (archimed_cor1 (M * (2 * PI / om) / (Rabs K + 1))) as [N [small Npos]].
    { apply Rdiv_lt_0_compat; [nra|pose proof (Rabs_pos K); lra]. }
    apply lt_INR in Npos; cbn in Npos; exists (1 + INR N * (2 * PI / om)); split; [nra|split].
    + replace (om * (1 + INR N * (2 * PI / om) - 1)) with (0 + 2 * INR N * PI) by (field; lra).
      rewrite sin_period; apply sin_0.
    + apply (Rmult_lt_compat_l (INR N * (Rabs K + 1))) in small; [|pose proof (Rabs_pos K); nra].
      replace (INR N * (Rabs K + 1) * / INR N) with (Rabs K + 1) in small by (field; lra).
      replace (INR N * (Rabs K + 1) * (M * (2 * PI / om) / (Rabs K + 1))) with (M * (INR N * (2 * PI / om))) in small
        by (field; pose proof (Rabs_pos K); split; lra).
      replace (1 + INR N * (2 * PI / om) - 1) with (INR N * (2 * PI / om)) by ring.
      pose proof (Rle_abs (- K)); rewrite Rabs_Ropp in *; lra.
  - exists (1 + (Rabs K + 1) / M).
    assert (0 < (Rabs K + 1) / M) by (apply Rdiv_lt_0_compat; [pose proof (Rabs_pos K); lra|exact Mpos]).
    split; [lra|split; [replace (0 * (1 + (Rabs K + 1) / M - 1)) with 0 by ring; apply sin_0|]].
    replace (M * (1 + (Rabs K + 1) / M - 1)) with (Rabs K + 1) by (field; lra).
    pose proof (Rle_abs (- K)); rewrite Rabs_Ropp in *; lra.
Qed.

(* ---- The same with e^(r t) beside a number later on, r > 0 ---- *)

Definition surge (r : R) (p : list R) (a : R) : R -> R :=
  glued (fun _ => 0) (glued (fun t => exp (r * t) * poly p t) (fun t => exp (r * t) * a) 1) 0.
Lemma exp_poly_flow : forall r q t,
  derivable_pt_lim (fun s => exp (r * s) * poly q s) t (exp (r * t) * (dpoly q t + r * poly q t)).
Proof.
  intros r q t; apply (derivable_same (fun s => exp (r * s) * poly q s) _ t
    (r * exp (r * t) * poly q t + exp (r * t) * dpoly q t)); [reflexivity|ring|].
  apply (derivable_pt_lim_mult (fun s => exp (r * s)) (poly q)); [apply exp_flow|apply poly_flow].
Qed.
Lemma surge_flow : forall r p p' a a', (forall s, dpoly p s + r * poly p s = poly p' s) -> a' = r * a ->
  poly p 0 = 0 -> poly p' 0 = 0 -> poly p 1 = a -> poly p' 1 = a' ->
  forall t, derivable_pt_lim (surge r p a) t (surge r p' a' t).
Proof.
  intros r p p' a a' D A p0 p0' p1 p1' t; unfold surge; apply glued_flow.
  - unfold glued; destruct (Rle_dec 0 1); [rewrite p0; ring|lra].
  - intro L; unfold glued; destruct (Rle_dec t 0); [apply derivable_pt_lim_const|lra].
  - intro L; apply glued_flow; [now rewrite p1| |]; intro M; unfold glued.
    + eapply derivable_same; [reflexivity| |apply exp_poly_flow]; rewrite D.
      destruct (Rle_dec t 0); [replace t with 0 by lra; rewrite p0'; ring|]; destruct (Rle_dec t 1); [reflexivity|lra].
    + apply (derivable_same (fun s => a * exp (r * s)) _ t (a * (r * exp (r * t)))); [intro; ring| |].
      * destruct (Rle_dec t 0); [lra|]; destruct (Rle_dec t 1); [replace t with 1 by lra; rewrite p1'|]; rewrite A; ring.
      * apply (derivable_pt_lim_scal (fun s => exp (r * s))), exp_flow.
Qed.
Definition surge_energy (r : R) (P : list R) (A : R) : R -> R :=
  glued (fun _ => 0) (glued (fun t => exp (2 * r * t) * poly P t - poly P 0)
    (fun t => exp (2 * r * 1) * poly P 1 - poly P 0 + A * (exp (2 * r * t) - exp (2 * r * 1))) 1) 0.
Lemma surge_energy_flow : forall r P p a A, (forall s, dpoly P s + 2 * r * poly P s = poly p s ^ 2) -> poly p 0 = 0 ->
  poly p 1 = a -> 2 * r * A = a ^ 2 -> forall t, derivable_pt_lim (surge_energy r P A) t (surge r p a t ^ 2).
Proof.
  intros r P p a A D p0 p1 H t; unfold surge_energy, surge.
  assert (E : exp (2 * r * t) = exp (r * t) ^ 2) by (rewrite <- (Rmult_1_r (exp (r * t) ^ 2)); cbn [pow];
    rewrite !Rmult_1_r, <- exp_plus; f_equal; ring).
  apply glued_flow.
  - unfold glued; destruct (Rle_dec 0 1); [rewrite Rmult_0_r, exp_0; ring|lra].
  - intro L; unfold glued; destruct (Rle_dec t 0); [|lra].
    eapply derivable_same; [reflexivity| |apply derivable_pt_lim_const]; ring.
  - intro L; apply glued_flow; [ring| |]; intro M; unfold glued.
    + apply (derivable_same (fun s => exp (2 * r * s) * poly P s - poly P 0) _ t
        (exp (2 * r * t) * (dpoly P t + 2 * r * poly P t) - 0)); [reflexivity| |].
      * rewrite D, E; destruct (Rle_dec t 0); [replace t with 0 by lra; rewrite p0; ring|].
        destruct (Rle_dec t 1); [ring|lra].
      * apply (derivable_pt_lim_minus (fun s => exp (2 * r * s) * poly P s) (fun _ => poly P 0));
          [apply exp_poly_flow|apply derivable_pt_lim_const].
    + apply (derivable_same (fun s => A * exp (2 * r * s)
        + (exp (2 * r * 1) * poly P 1 - poly P 0 - A * exp (2 * r * 1))) _ t (A * (2 * r * exp (2 * r * t)) + 0)); [intro; ring| |].
      * destruct (Rle_dec t 0); [lra|]; transitivity (2 * r * A * exp (r * t) ^ 2); [rewrite E; ring|rewrite H].
        destruct (Rle_dec t 1); [replace t with 1 by lra; rewrite p1|]; ring.
      * apply (derivable_pt_lim_plus (fun s => A * exp (2 * r * s))); [|apply derivable_pt_lim_const].
        apply (derivable_pt_lim_scal (fun s => exp (2 * r * s))), exp_flow.
Qed.
Lemma surge_energy_start : forall r P A, surge_energy r P A 0 = 0.
Proof. intros; unfold surge_energy, glued; destruct (Rle_dec 0 0); [reflexivity|lra]. Qed.
Lemma surge_energy_end : forall r P A t, 1 < t -> surge_energy r P A t
  = exp (2 * r * 1) * poly P 1 - poly P 0 + A * (exp (2 * r * t) - exp (2 * r * 1)).
Proof. intros r P A t T; unfold surge_energy, glued; destruct (Rle_dec t 0); [lra|]; destruct (Rle_dec t 1); [lra|reflexivity]. Qed.
Lemma surge_late : forall r K M, 0 < r -> 0 < M -> exists t, 1 < t /\ 0 < K + M * (exp (2 * r * t) - exp (2 * r * 1)).
Proof.
  intros r K M rp Mp; set (u := (Rabs K + 1) / (M * r)).
  assert (U : 0 < u) by (apply Rdiv_lt_0_compat; [pose proof (Rabs_pos K); lra|now apply Rmult_lt_0_compat]).
  exists (1 + u); split; [lra|].
  replace (exp (2 * r * (1 + u))) with (exp (2 * r * 1) * exp (2 * r * u)) by (rewrite <- exp_plus; f_equal; ring).
  assert (R0 : 0 < r * u) by now apply Rmult_lt_0_compat.
  pose proof (exp_ineq1 (2 * r * u) ltac:(lra)) as A; pose proof (exp_ineq1 (2 * r * 1) ltac:(lra)) as B.
  assert (C : r * u <= exp (2 * r * 1) * exp (2 * r * u) - exp (2 * r * 1)).
  { pose proof (Rmult_le_pos (exp (2 * r * 1) - 1) (exp (2 * r * u) - 1) ltac:(lra) ltac:(lra)); lra. }
  apply (Rmult_le_compat_l M) in C; [|lra]; replace (M * (r * u)) with (Rabs K + 1) in C by (unfold u; field; lra).
  pose proof (Rle_abs (- K)); rewrite Rabs_Ropp in *; lra.
Qed.

(* ---- The same in samples: given ones, then a rotation by the angle of C + i S ---- *)

Fixpoint turned (C T : R) (k : nat) : R * R :=
  match k with O => (1, 0) | S j => let (c, s) := turned C T j in (C * c - T * s, T * c + C * s) end.
Definition swing (first : list R) (a b C T : R) (t : nat) : R :=
  if (t <? length first)%nat then nth t first 0
  else let (c, s) := turned C T (t - length first) in a * c + b * s.

Lemma swing_next : forall first a b C T first' a' b', first' = tl first ++ [a] -> first <> [] ->
  a' = a * C + b * T -> b' = b * C - a * T ->
  forall t, swing first a b C T (S t) = swing first' a' b' C T t.
Proof.
  intros [|x first] a b C T first' a' b' -> some -> -> t; [contradiction|]; unfold swing; cbn [tl length].
  rewrite app_length; cbn [length]; rewrite Nat.add_1_r.
  destruct (Nat.ltb_spec (S t) (S (length first))) as [L|L].
  - rewrite (proj2 (Nat.ltb_lt t (S (length first)))) by lia; cbn [nth]; now rewrite app_nth1 by lia.
  - destruct (Nat.ltb_spec t (S (length first))) as [M|M].
    + assert (t = length first) as -> by lia; rewrite app_nth2 by lia.
      rewrite !Nat.sub_diag; cbn [turned nth]; ring.
    + replace (S t - S (length first))%nat with (S (t - S (length first))) by lia; cbn [turned].
      destruct (turned C T (t - S (length first))) as [c s]; ring.
Qed.
Lemma turned_unit : forall C T k, C * C + T * T = 1 ->
  let (c, s) := turned C T k in c * c + s * s = 1 /\ Rabs (c * s) <= 1 /\ Rabs (s * s) <= 1.
Proof.
  intros C T k unit; induction k as [|k IH]; cbn [turned].
  - rewrite !Rmult_0_r, Rabs_R0; lra.
  - destruct (turned C T k) as [c s]; destruct IH as [E _].
    assert (Q : (C * c - T * s) * (C * c - T * s) + (T * c + C * s) * (T * c + C * s) = 1).
    { transitivity ((C * C + T * T) * (c * c + s * s)); [ring|rewrite E, unit; ring]. }
    set (x := C * c - T * s) in *; set (y := T * c + C * s) in *.
    pose proof (Rle_0_sqr (x - y)); pose proof (Rle_0_sqr (x + y)); pose proof (Rle_0_sqr x); pose proof (Rle_0_sqr y).
    unfold Rsqr in *; split; [exact Q|split; apply Rabs_le; lra].
Qed.
Lemma sum_apart : forall (f g : nat -> R) c N,
  sum_f_R0 (fun t => f t - c * g t) N = sum_f_R0 f N - c * sum_f_R0 g N.
Proof. intros f g c N; induction N as [|N IH]; cbn [sum_f_R0]; [ring|]; rewrite IH; ring. Qed.
Lemma sums_late : forall (D : nat -> R) n M al be C T, C * C + T * T = 1 -> 0 < M ->
  (forall k, let (c, s) := turned C T k in let (c', s') := turned C T (S k) in
    D (n + k)%nat = M * (c * c + s * s) + (al * (c' * s') + be * (s' * s')) - (al * (c * s) + be * (s * s))) ->
  exists N, 0 < sum_f_R0 D N.
Proof.
  intros D n M al be C T unit pos step.
  set (v := fun k => let (c, s) := turned C T k in al * (c * s) + be * (s * s)).
  assert (small : forall k, Rabs (v k) <= Rabs al + Rabs be).
  { intro k; unfold v; pose proof (turned_unit C T k unit) as U; destruct (turned C T k) as [c s].
    destruct U as [_ [U1 U2]]; eapply Rle_trans; [apply Rabs_triang|]; rewrite (Rabs_mult al), (Rabs_mult be).
    pose proof (Rmult_le_compat_l _ _ _ (Rabs_pos al) U1); pose proof (Rmult_le_compat_l _ _ _ (Rabs_pos be) U2); lra. }
  assert (one : forall k, D (n + k)%nat = M + v (S k) - v k).
  { intro k; specialize (step k); unfold v; pose proof (turned_unit C T k unit) as U.
    destruct (turned C T k) as [c s], (turned C T (S k)) as [c' s']; rewrite step, (proj1 U); ring. }
  assert (sum : forall N, sum_f_R0 D (n + N) = sum_f_R0 D n + M * INR N + v (S N) - v 1%nat).
  { induction N as [|N IH]; [rewrite Nat.add_0_r; cbn [INR]; ring|].
    rewrite <- plus_n_Sm, S_INR; cbn [sum_f_R0]; rewrite IH, plus_n_Sm, one; ring. }
  set (K := Rabs (sum_f_R0 D n) + 2 * (Rabs al + Rabs be)).
  assert (K0 : 0 <= K) by (unfold K; pose proof (Rabs_pos (sum_f_R0 D n)); pose proof (Rabs_pos al); pose proof (Rabs_pos be); lra).
  destruct (archimed_cor1 (M / (K + 1))) as [N [below Npos]]; [apply Rdiv_lt_0_compat; lra|].
  apply lt_INR in Npos; cbn in Npos; exists (n + N)%nat; rewrite sum.
  apply (Rmult_lt_compat_l (INR N * (K + 1))) in below; [|nra].
  replace (INR N * (K + 1) * / INR N) with (K + 1) in below by (field; lra).
  replace (INR N * (K + 1) * (M / (K + 1))) with (M * INR N) in below by (field; lra).
  pose proof (Rle_abs (- sum_f_R0 D n)); pose proof (Rle_abs (- v (S N))); pose proof (Rle_abs (v 1%nat)).
  rewrite !Rabs_Ropp in *; pose proof (small (S N)); pose proof (small 1%nat); unfold K in *; lra.
Qed.

(* ---- Samples without end after one: x'P x does not fall, and is at most K times squares of samples to come ---- *)

Definition impulse (t : nat) : R := match t with O => 1 | _ => 0 end.
Definition goes_on (n : nat) (P now next later : list (list Z)) (K : Z) : bool :=
  (0 <? K)%Z && nonneg n (bilinear P next next ++ times (-1) (bilinear P now now)) &&
  nonneg n (times K (squares later) ++ times (-1) (bilinear P now now)).

Lemma impulse_energy : forall (f : nat -> R) N, (forall t, f t = impulse t) -> sum_f_R0 f N = 1.
Proof. intros f N E; induction N as [|N IH]; cbn [sum_f_R0]; [|rewrite IH]; rewrite E; cbn [impulse]; lra. Qed.
Lemma windows : forall (g : nat -> R) a m T, 0 < a -> (forall t, 0 <= g t) ->
  (forall t, (T <= t)%nat -> a <= sum_f_R0 (fun j => g (t + j)%nat) m) -> forall c, exists N, c < sum_f_R0 g N.
Proof.
  intros g a m T a0 g0 W c.
  assert (B : forall k, exists N, (T <= N)%nat /\ INR k * a <= sum_f_R0 g N).
  { induction k as [|k [N [L IH]]].
    - exists T; split; [lia|]; cbn [INR]; rewrite Rmult_0_l; now apply cond_pos_sum.
    - exists (S N + m)%nat; split; [lia|]; rewrite S_INR, (tech2 g N (S N + m)) by lia.
      replace (S N + m - S N)%nat with m by lia; pose proof (W (S N) ltac:(lia)); lra. }
  pose proof (Rabs_pos c); destruct (archimed_cor1 (a / (Rabs c + 1))) as [k [below kpos]]; [apply Rdiv_lt_0_compat; lra|].
  apply lt_INR in kpos; cbn in kpos; destruct (B k) as [N [_ S]]; exists N; pose proof (Rle_abs c).
  apply (Rmult_lt_compat_l (INR k * (Rabs c + 1))) in below; [|nra].
  replace (INR k * (Rabs c + 1) * / INR k) with (Rabs c + 1) in below by (field; lra).
  replace (INR k * (Rabs c + 1) * (a / (Rabs c + 1))) with (INR k * a) in below by (field; lra); lra.
Qed.
Theorem without_end : forall n P now next later K l m T (z : nat -> list R) (g : nat -> R),
  goes_on n P now next later K = true -> (forall t, length (z t) = n) -> (forall t, 0 <= g t) -> 0 < l ->
  (forall t, (T <= t)%nat -> at_ now (z (S t)) = at_ next (z t)) ->
  (forall t, (T <= t)%nat -> value (squares later) (z t) <= l * sum_f_R0 (fun j => g (t + j)%nat) m) ->
  0 < value (bilinear P now now) (z T) -> forall c, exists N, c < sum_f_R0 g N.
Proof.
  intros n P now next later K l m T z g test len g0 l0 step out start; unfold goes_on in test.
  rewrite !andb_true_iff, Z.ltb_lt in test; destruct test as [[K0 rises] seen]; apply IZR_lt in K0.
  set (v := fun t => value (bilinear P now now) (z t)) in *.
  assert (up : forall k, v T <= v (T + k)%nat).
  { induction k as [|k IH]; [rewrite Nat.add_0_r; lra|]; eapply Rle_trans; [exact IH|].
    pose proof (nonneg_sound n _ (z (T + k)%nat) rises (len _)) as Q; rewrite value_app, value_times in Q.
    rewrite <- plus_n_Sm; unfold v; rewrite (value_bilinear P now now (z (S (T + k)))), (step (T + k)%nat) by lia.
    rewrite <- value_bilinear; lra. }
  apply (windows g (v T / (IZR K * l)) m T); [apply Rdiv_lt_0_compat; [exact start|now apply Rmult_lt_0_compat]|exact g0|].
  intros t Ht; pose proof (nonneg_sound n _ (z t) seen (len _)) as Q; rewrite value_app, !value_times in Q.
  pose proof (up (t - T)%nat) as U; replace (T + (t - T))%nat with t in U by lia; specialize (out t Ht).
  apply (Rmult_le_compat_l (IZR K)) in out; [|lra].
  apply (Rmult_le_reg_l (IZR K * l)); [now apply Rmult_lt_0_compat|].
  replace (IZR K * l * (v T / (IZR K * l))) with (v T) by (field; lra); unfold v in *; lra.
Qed.
